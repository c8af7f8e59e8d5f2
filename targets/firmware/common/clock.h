// SPDX-License-Identifier: GPL-2.0-or-later
//
// The clock tree of a Blue Pill: HSE is a crystal of 8 MHz.

#pragma once

#include <stdint.h>

#define HSI_HZ 8000000u
#define HSE_HZ 8000000u

// SYSCLK = HCLK = PCLK2 = 72 MHz, PCLK1 = 36 MHz, all the chip allows. Waits for ever if there is no crystal.
void clock_72mhz(void);

// HCLK and the clocks of the two buses, as the registers say now, in Hz.
uint32_t clock_hclk_hz(void);
uint32_t clock_pclk1_hz(void);
uint32_t clock_pclk2_hz(void);
