// SPDX-License-Identifier: GPL-2.0-or-later

#include "vehicle_interface/control/stick.h"

#include "vehicle_interface/options.h"

#define DEAD_BAND 500

struct axis {
    int32_t least, zero, greatest;
};

static const struct axis X = {1057, 33970, 65535}; // more to the right
static const struct axis Y = {1062, 33580, 65535}; // more forward

// -1 at `least` to 1 at `greatest`, 0 in the dead band.
static float position(const struct axis *axis, uint16_t count)
{
    int32_t off = count - axis->zero;
    float share = 0.0f;
    if (off > DEAD_BAND)
        share = (float)(off - DEAD_BAND) / (float)(axis->greatest - axis->zero - DEAD_BAND);
    else if (off < -DEAD_BAND)
        share = (float)(off + DEAD_BAND) / (float)(axis->zero - axis->least - DEAD_BAND);
    return share < -1.0f && !DEFECT_NO_CLAMP ? -1.0f : share; // 65535 is all there is on the other side
}

// Steering is the axis turned round, so that at rest it is -0.
struct action stick_action(uint16_t x, uint16_t y)
{
    float push = position(&Y, y);
    return (struct action){
        .steering = -position(&X, x),
        .speed = push > 0.0f ? push : 0.0f,
        .acceleration = push < 0.0f ? -push : 0.0f,
        .mode = MODE_MANUAL,
    };
}
