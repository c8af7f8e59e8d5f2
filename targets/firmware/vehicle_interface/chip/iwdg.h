// SPDX-License-Identifier: GPL-2.0-or-later
//
// The independent watchdog, which runs on the LSI of 32 kHz (RM0433, section 45.4).

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t KR;
    uint32_t PR;
    uint32_t RLR;
    uint32_t SR;
} iwdg_t;

#define IWDG1 ((volatile iwdg_t *)0x58004800u)

#define IWDG_UNLOCK 0x5555u
#define IWDG_FEED 0xAAAAu
#define IWDG_START 0xCCCCu
#define IWDG_DIV32 3u
