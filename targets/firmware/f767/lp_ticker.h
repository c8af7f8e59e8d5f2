// SPDX-License-Identifier: GPL-2.0-or-later
//
// A ticker of low power, in the style of Mbed OS 6: LPTIM1 on the LSE, 16 bits at 32768 Hz, which also counts in Stop mode.
// What is awaited is a tick; an interrupt may come early, so whoever waits looks at the count and asks again.

#pragma once

#include <stdbool.h>
#include <stdint.h>

// Starts the LSE, which takes up to seconds after power-on, and the ticker. Once; interrupts may be on.
void lp_ticker_init(void);

// The present tick.
uint32_t lp_ticker_read(void);

// Calls lp_ticker_irq_handler at a tick, not before a few from now; replaces what was asked for before.
void lp_ticker_set_interrupt(uint32_t tick);

// Calls it as soon as interrupts are on.
void lp_ticker_fire_interrupt(void);

// Says whether Stop mode is allowed: not before what was asked for has reached the timer.
bool lp_ticker_allows_stop(void);

// Whoever uses the ticker defines it.
void lp_ticker_irq_handler(void);
