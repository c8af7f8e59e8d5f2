// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/sensors/angles.h"

#define PI 3.14159265f

struct angles angles;

static float size(float x) { return x < 0.0f ? -x : x; }

// Of a ratio 0..1; wrong by 0.0002 rad at most (Abramowitz and Stegun, 4.4.49, cut short).
static float small_atan(float x)
{
    float s = x * x;
    return x * (0.9998660f + s * (-0.3302995f + s * (0.1801410f + s * (-0.0851330f + s * 0.0208351f))));
}

static float atan2_of(float y, float x)
{
    float ax = size(x), ay = size(y);
    if (ax == 0.0f && ay == 0.0f)
        return 0.0f;
    float angle = ay < ax ? small_atan(ay / ax) : PI / 2.0f - small_atan(ax / ay);
    if (x < 0.0f)
        angle = PI - angle;
    return y < 0.0f ? -angle : angle;
}

static float length(float a, float b) { return __builtin_sqrtf(a * a + b * b); }

// Roll and pitch are how gravity leans; yaw is where the field points once it is turned level by them.
static struct vector from_field(struct vector a, struct vector m)
{
    float level = length(a.y, a.z), whole = length(level, a.x);
    if (level == 0.0f)
        return (struct vector){0};
    float sin_roll = a.y / level, cos_roll = a.z / level;
    float sin_pitch = -a.x / whole, cos_pitch = level / whole;
    float forward = m.x * cos_pitch + (m.y * sin_roll + m.z * cos_roll) * sin_pitch;
    float left = m.y * cos_roll - m.z * sin_roll;
    return (struct vector){atan2_of(a.y, a.z), atan2_of(-a.x, level), atan2_of(-left, forward)};
}

void angles_update(struct vector rate_rad_s, struct vector acceleration, struct vector field, float dt_s)
{
    angles.from_field_rad = from_field(acceleration, field);
    angles.from_rates_rad.x += rate_rad_s.x * dt_s;
    angles.from_rates_rad.y += rate_rad_s.y * dt_s;
    angles.from_rates_rad.z += rate_rad_s.z * dt_s;
}
