// SPDX-License-Identifier: GPL-2.0-or-later
//
// CRC calculation unit (RM0008, section 4).

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t DR;
    uint32_t IDR;
    uint32_t CR;
} crc_t;

#define CRC ((volatile crc_t *)0x40023000u)

#define CRC_CR_RESET (1u << 0)
