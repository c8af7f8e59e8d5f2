// SPDX-License-Identifier: GPL-2.0-or-later
//
// The pins from the tachometers: each falling edge is a slot of a wheel's disc, and comes with its time.

#pragma once

#include <stdint.h>

// In the order of the reports: left front PE7, right front PE8, left back PG9, right back PG14.
enum wheel { LEFT_FRONT, RIGHT_FRONT, LEFT_BACK, RIGHT_BACK, WHEELS };

void wheels_start(void);

// To be defined by whoever counts; called from interrupts.
void wheels_edge(enum wheel wheel, uint32_t now_us);
