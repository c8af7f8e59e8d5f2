// SPDX-License-Identifier: GPL-2.0-or-later
//
// How fast the wheels turn, from the time between two slots of their discs (manual, chapter on the tachometers):
// 60 / (slots * dt), in rpm, where dt is also never less than what has passed since the last slot. It is 0 where that is a
// second (so nothing below 3 rpm is seen) or the result is above 1000, and the median of three readings is taken. It defines
// wheels_edge of wheels.h.

#pragma once

#include <stdint.h>

#include "rover/board/motors.h"
#include "rover/board/wheels.h"

void tachometer_start(void);

// To be called every TACHOMETER_TICKS.
#define TACHOMETER_TICKS 2u
void tachometer_update(uint32_t now_us);

float tachometer_rpm(enum wheel wheel); // as of the last update
uint32_t tachometer_slots(enum wheel wheel);

// The slower wheel of a side: the other one may be spinning (G2 application.cpp read_tachometers).
float tachometer_side_rpm(enum side side);
