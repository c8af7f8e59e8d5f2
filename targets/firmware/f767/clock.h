// SPDX-License-Identifier: GPL-2.0-or-later
//
// The fastest clock of the chip.

#pragma once

#define HCLK_HZ 216000000u
#define PCLK1_HZ (HCLK_HZ / 4)

// From HSI to HCLK at 216 MHz, PCLK1 at 54 MHz and PCLK2 at 108 MHz, by the ST-LINK's 8 MHz at OSC_IN and over-drive
// (RM0410, section 4.1.4), with the instruction cache.
void clock_start(void);
