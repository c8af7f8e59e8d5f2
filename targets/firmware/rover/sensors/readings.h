// SPDX-License-Identifier: GPL-2.0-or-later
//
// From the sensors' registers to the units of the report: scales, the gyroscope's bias, the magnetometer's sensitivity and axes.

#pragma once

#include <stdbool.h>
#include <stdint.h>

// As they are read in one go from MPU_INT_STATUS on: that register, then acceleration, temperature and rate.
#define MOTION_BYTES 15u

// As they are read in one go from AK_ST1 on: that register, the field, and ST2.
#define FIELD_BYTES 8u

void readings_begin_calibration(void);

// Takes a reading at rest. True if it was the last one that is needed.
bool readings_calibrate(const uint8_t *bytes);

// The three bytes from AK_ASAX on.
void readings_set_sensitivity(const uint8_t *bytes);

// Each puts what it has read into `imu` of imu.h.
void readings_take_motion(const uint8_t *bytes);
void readings_take_field(const uint8_t *bytes);
