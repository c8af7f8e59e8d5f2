// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/control/drive.h"

#include <stdbool.h>

#include "rover/board/time.h"
#include "rover/control/tachometer.h"
#include "rover/options.h"

#define DT_S ((float)DRIVE_TICKS / TICK_HZ)

static struct {
    float throttle;
    float setpoint_rpm;
    struct pid pid;
} sides[SIDES];

static bool pid_mode;

void drive_start(void)
{
    for (unsigned side = LEFT; side < SIDES; ++side)
        sides[side].pid = PID_DEFAULT;
}

static float checked(float throttle)
{
    if (DEFECT_THROTTLE_UNCHECKED)
        return throttle;
    if (throttle != throttle)
        return 0.0f;
    return throttle > 1.0f ? 1.0f : throttle < -1.0f ? -1.0f : throttle;
}

static void put(enum side side, float throttle)
{
    sides[side].throttle = checked(throttle);
    motors_put(side, sides[side].throttle);
}

static bool is_chosen(enum side side, uint8_t flags) { return flags >> side & 1u; }

void drive_throttles(float left, float right, uint8_t flags)
{
    const float throttles[SIDES] = {left, right};
    pid_mode = false;
    for (unsigned side = LEFT; side < SIDES; ++side)
        if (is_chosen(side, flags))
            put(side, throttles[side]);
}

static void reset_controllers(void)
{
    for (unsigned side = LEFT; side < SIDES; ++side)
        pid_reset(&sides[side].pid);
}

void drive_setpoints(float left_rpm, float right_rpm, uint8_t flags)
{
    const float setpoints_rpm[SIDES] = {left_rpm, right_rpm};
    if (!pid_mode && !DEFECT_PID_NO_RESET)
        reset_controllers();
    pid_mode = true;
    for (unsigned side = LEFT; side < SIDES; ++side)
        if (is_chosen(side, flags))
            sides[side].setpoint_rpm = setpoints_rpm[side];
}

void drive_gains(float kp, float kd, float ki)
{
    for (unsigned side = LEFT; side < SIDES; ++side)
        sides[side].pid = (struct pid){.kp = kp, .kd = kd, .ki = ki};
}

void drive_stop(void)
{
    pid_mode = false;
    for (unsigned side = LEFT; side < SIDES; ++side) {
        sides[side].setpoint_rpm = 0.0f;
        if (DEFECT_LINK_STOPS_REPORT_ONLY)
            sides[side].throttle = 0.0f;
        else
            put(side, 0.0f);
    }
}

static float measured_rpm(enum side side)
{
    float rpm = tachometer_side_rpm(side);
    return sides[side].throttle < 0.0f ? -rpm : rpm;
}

void drive_update(void)
{
    if (!pid_mode)
        return;
    for (unsigned side = LEFT; side < SIDES; ++side)
        put(side, pid_update(&sides[side].pid, sides[side].setpoint_rpm, measured_rpm(side), DT_S));
}

float drive_throttle_of(enum side side) { return sides[side].throttle; }

float drive_setpoint_of(enum side side) { return sides[side].setpoint_rpm; }

const struct pid *drive_pid_of(enum side side) { return &sides[side].pid; }
