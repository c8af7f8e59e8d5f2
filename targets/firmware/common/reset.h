// SPDX-License-Identifier: GPL-2.0-or-later
//
// Why the chip was reset last (RM0008, 7.3.10), for tests that a reset is part of.

#pragma once

#include "chip/stm32f103.h"

// The flags of RCC_CSR, which are then cleared, so that the next reset's stand alone.
static inline uint32_t reset_cause(void)
{
    uint32_t cause = RCC->CSR & RCC_CSR_CAUSES;
    RCC->CSR |= RCC_CSR_RMVF;
    RCC->CSR &= ~RCC_CSR_RMVF;
    return cause;
}

__attribute__((noreturn)) static inline void reset_by_software(void)
{
    DSB();
    SCB->AIRCR = AIRCR_VECTKEY | AIRCR_SYSRESETREQ;
    for (;;) {
    }
}
