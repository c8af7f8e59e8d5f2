// SPDX-License-Identifier: GPL-2.0-or-later
//
// The start of the published rover, which is an image of Mbed OS 6: between the clocks and the program the operating system
// starts its low-power ticker (f767/lp_ticker.h), which awaits the LSE and then flags of LPTIM1.

#pragma once

// clock_start, and then the ticker with an alarm each 100 ms, which the rover needs for nothing.
void clock_and_tickers_start(void);
