// SPDX-License-Identifier: GPL-2.0-or-later
//
// Interrupts from pins (RM0433, section 20.6), and the ports they come from (section 12.3).

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t RTSR1;
    uint32_t FTSR1;
    uint32_t SWIER1;
    uint32_t reserved0[29];
    uint32_t CPUIMR1;
    uint32_t CPUEMR1;
    uint32_t CPUPR1; // write one to clear
} exti_t;

#define EXTI ((volatile exti_t *)0x58000000u)

_Static_assert(__builtin_offsetof(exti_t, CPUIMR1) == 0x80, "EXTI layout");

#define SYSCFG_EXTICR ((volatile uint32_t *)0x58000408u)

static inline void exti_port(unsigned line, char port)
{
    volatile uint32_t *reg = &SYSCFG_EXTICR[line / 4];
    unsigned shift = line % 4 * 4;
    *reg = (*reg & ~(0xFu << shift)) | (uint32_t)(port - 'A') << shift;
}
