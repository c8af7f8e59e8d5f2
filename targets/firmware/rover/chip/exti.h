// SPDX-License-Identifier: GPL-2.0-or-later
//
// Interrupts from pins (RM0410, section 11), and the ports they come from (section 7.2).

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t IMR;
    uint32_t EMR;
    uint32_t RTSR;
    uint32_t FTSR;
    uint32_t SWIER;
    uint32_t PR; // write one to clear
} exti_t;

#define EXTI ((volatile exti_t *)0x40013C00u)

#define SYSCFG_EXTICR ((volatile uint32_t *)0x40013808u)

static inline void exti_port(unsigned line, char port)
{
    volatile uint32_t *reg = &SYSCFG_EXTICR[line / 4];
    unsigned shift = line % 4 * 4;
    *reg = (*reg & ~(0xFu << shift)) | (uint32_t)(port - 'A') << shift;
}
