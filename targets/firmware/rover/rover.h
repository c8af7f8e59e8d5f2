// SPDX-License-Identifier: GPL-2.0-or-later
//
// What the rover does when something has come and when the clock ticks.

#pragma once

#include <stdint.h>

void rover_start(void);

// To be called after every interrupt.
void rover_poll(uint32_t now_us);

// To be called for each tick, from 0 on.
void rover_tick(uint32_t tick, uint32_t now_us);
