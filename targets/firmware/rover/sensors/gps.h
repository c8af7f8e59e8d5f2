// SPDX-License-Identifier: GPL-2.0-or-later
//
// Where the rover is, as far as the receiver knows.

#pragma once

#include <stdint.h>

#include "rover/sensors/nmea.h"

struct gps {
    struct position position; // without a fix the last one that was known
    bool failed;              // no sound sentence for a while
};

extern struct gps gps;

void gps_start(void);

// Takes what the receiver has sent.
void gps_poll(uint32_t now_us);

// To be called at each tick.
void gps_tick(uint32_t now_us);
