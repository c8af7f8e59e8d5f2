// SPDX-License-Identifier: GPL-2.0-or-later
//
// Time: microseconds since the start, which wrap after 71 minutes, so that only spans below that are ever taken; and the
// base tick, of which all periods are multiples.

#pragma once

#include <stdint.h>

#define TICK_HZ 100u
#define TICK_US (1000000u / TICK_HZ)

void time_start(void);

uint32_t time_us(void);

// The number of ticks so far.
uint32_t time_ticks(void);
