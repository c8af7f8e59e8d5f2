// SPDX-License-Identifier: GPL-2.0-or-later
//
// The rover's attitude as a quaternion, from rates, acceleration and magnetic field, by the gradient descent of S. Madgwick,
// "An efficient orientation filter for inertial and inertial/magnetic sensor arrays", 2010.
//
// The axes of the rover are those of the sensor (X forward, Y left, Z up); those of the earth have X towards magnetic north
// and Z up, so that the quaternion is 1, 0, 0, 0 for a level rover that looks north.

#pragma once

#include <stdbool.h>

struct vector {
    float x, y, z;
};

struct quaternion {
    float w, x, y, z;
};

extern struct quaternion attitude;

void attitude_start(void);

// Rates in rad/s; acceleration (upwards at rest) and field in any units. Without a field it is not `has_field`.
void attitude_update(struct vector rate, struct vector acceleration, struct vector field, bool has_field, float dt_s);
