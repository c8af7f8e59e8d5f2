// SPDX-License-Identifier: GPL-2.0-or-later
//
// The clock tree: HSE is the 8 MHz that the board's ST-LINK puts out (UM1974, 6.8).

#pragma once

#define HCLK_HZ 216000000u
#define PCLK1_HZ (HCLK_HZ / 4)        // 54 MHz, the most that APB1 allows
#define TIMERS1_HZ (2 * PCLK1_HZ)     // timers on APB1; TIMPRE is 0 (RM0410, 5.2)
#define TIMERS2_HZ HCLK_HZ            // timers on APB2

// All that the chip allows, and the instruction cache. Waits for ever if the ST-LINK gives no clock.
void clock_start(void);
