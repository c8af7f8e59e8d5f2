// SPDX-License-Identifier: GPL-2.0-or-later
//
// External interrupts and events (RM0008, section 10.3).

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t IMR;
    uint32_t EMR;
    uint32_t RTSR;
    uint32_t FTSR;
    uint32_t SWIER;
    uint32_t PR;
} exti_t;

#define EXTI ((volatile exti_t *)0x40010400u)
