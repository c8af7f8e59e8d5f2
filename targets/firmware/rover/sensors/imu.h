// SPDX-License-Identifier: GPL-2.0-or-later
//
// The MPU-9250 with its magnetometer AK8963, on I2C1: set up, calibrated, read ten times a second, in the units of the
// report. Whatever hangs or is missing there, nothing else waits for it; it is set up anew each second.

#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "rover/sensors/attitude.h"

struct imu {
    bool valid;       // acceleration, rate and temperature are
    bool field_valid; // the field is
    bool failed;      // the sensor does not answer, or not as it should
    struct vector acceleration_g;
    struct vector rate_deg_s;
    struct vector field_mgauss; // in the axes of the other two
    float temperature_c;
};

extern struct imu imu;

void imu_start(void);

// To be called at each tick, with its number.
void imu_tick(uint32_t tick);

// To be called whenever something may have happened on the bus.
void imu_poll(void);

// To be called by imu.c with each new reading; to be defined by whoever wants it.
void imu_read(float dt_s);
