// SPDX-License-Identifier: GPL-2.0-or-later
//
// One speed controller: error in rpm in, throttle out (manual, chapter on the PID controller; the sign of the error is that
// of its listing, setpoint minus measured, not of its formula).

#pragma once

#define PID_MAX 1.0f
#define PID_MIN -1.0f

struct pid {
    float kp;         // throttle per rpm
    float kd;         // throttle per rpm/s
    float ki;         // throttle per rpm s
    float sum;        // of the error over time, in rpm s
    float last_error; // in rpm
};

// As G2 has them (config.h).
#define PID_DEFAULT ((struct pid){.kp = 0.01f, .kd = 0.0001f, .ki = 0.0001f})

void pid_reset(struct pid *pid);
float pid_update(struct pid *pid, float setpoint_rpm, float measured_rpm, float dt_s);
