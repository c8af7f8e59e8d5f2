// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/control/pid.h"

#include "rover/options.h"

void pid_reset(struct pid *pid) { pid->sum = pid->last_error = 0.0f; }

float pid_update(struct pid *pid, float setpoint_rpm, float measured_rpm, float dt_s)
{
    float error = setpoint_rpm - measured_rpm;
    float sum = pid->sum + error * dt_s;
    float output = pid->kp * error + pid->ki * sum + pid->kd * (error - pid->last_error) / dt_s;
    pid->last_error = error;
    float limited = output > PID_MAX ? PID_MAX : output < PID_MIN ? PID_MIN : output;
    if (DEFECT_PID_WINDUP || limited == output)
        pid->sum = sum; // at its limit the output has nothing to gain from a larger sum (choice)
    return limited;
}
