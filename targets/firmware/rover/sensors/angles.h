// SPDX-License-Identifier: GPL-2.0-or-later
//
// Roll, pitch and yaw as G0 has them, twice: from acceleration and field, and from summed rates, which drift.

#pragma once

#include "rover/sensors/attitude.h"

struct angles {
    struct vector from_field_rad, from_rates_rad; // x is roll, y pitch, z yaw
};

extern struct angles angles;

void angles_update(struct vector rate_rad_s, struct vector acceleration, struct vector field, float dt_s);
