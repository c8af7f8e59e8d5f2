// SPDX-License-Identifier: GPL-2.0-or-later
//
// The fastest clock of the chip.

#pragma once

#define CPU_HZ 480000000u
#define HCLK_HZ (CPU_HZ / 2)
#define PCLK1_HZ (HCLK_HZ / 2)

// From HSI to the CPU at 480 MHz, HCLK at 240 MHz and all PCLK at 120 MHz, by CSI (4 MHz) and PLL1 (x 240, / 2), at voltage
// scale 0: scale 1 with over-drive (RM0433, section 6.6.2), with the instruction cache.
void clock_start(void);
