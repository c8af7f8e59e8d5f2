// SPDX-License-Identifier: GPL-2.0-or-later
//
// The clock tree, that of the original's CubeMX project: CSI 4 MHz, PLL1 to 480 MHz for the core, PLL2 to 75 MHz for the ADC.

#pragma once

#define CORE_HZ 480000000u
#define HCLK_HZ (CORE_HZ / 2)
#define PCLK1_HZ (HCLK_HZ / 2)

// All that the chip allows, and the instruction cache. The data cache stays off, so that DMA and core see the same memory.
void clock_start(void);
