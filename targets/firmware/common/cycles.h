// SPDX-License-Identifier: GPL-2.0-or-later
//
// Time measured in cycles of HCLK by the core's own counter, DWT_CYCCNT (DDI 0403, C1.8.7).

#pragma once

#include <stdint.h>

#include "chip/core.h"

static inline void cycles_start(void)
{
    DEMCR |= DEMCR_TRCENA;
    DWT->CTRL |= DWT_CYCCNTENA;
}

static inline uint32_t cycles(void) { return DWT->CYCCNT; }

static inline void wait_cycles(uint32_t count)
{
    uint32_t start = cycles();
    while (cycles() - start < count) {
    }
}

// Waits until `start + count`, for a train of moments that must not drift; returns that moment, the start of the next.
static inline uint32_t wait_cycles_from(uint32_t start, uint32_t count)
{
    while (cycles() - start < count) {
    }
    return start + count;
}
