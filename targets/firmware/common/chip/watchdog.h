// SPDX-License-Identifier: GPL-2.0-or-later
//
// Independent watchdog (RM0008, section 19) and window watchdog (section 20).

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t KR;
    uint32_t PR;
    uint32_t RLR;
    uint32_t SR;
} iwdg_t;

#define IWDG ((volatile iwdg_t *)0x40003000u)

#define IWDG_KEY_START 0xCCCCu
#define IWDG_KEY_RELOAD 0xAAAAu
#define IWDG_KEY_UNLOCK 0x5555u
#define IWDG_SR_PVU (1u << 0)
#define IWDG_SR_RVU (1u << 1)

typedef struct {
    uint32_t CR;
    uint32_t CFR;
    uint32_t SR;
} wwdg_t;

#define WWDG ((volatile wwdg_t *)0x40002C00u)

#define WWDG_CR_WDGA (1u << 7)
#define WWDG_T 0x7Fu
#define WWDG_T6 0x40u
#define WWDG_CFR_TB_SHIFT 7
#define WWDG_CFR_EWI (1u << 9)
#define WWDG_SR_EWIF (1u << 0)
