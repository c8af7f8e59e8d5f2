// SPDX-License-Identifier: GPL-2.0-or-later
//
// The motors: left to a throttle of the host's (manual mode, also at power-up), or to the speed controllers (PID mode).
//
// Flags choose the sides a command is for: bit 0 left, bit 1 right. Speeds have the wheels' sign: the tachometers see none,
// so it is taken from the throttle.

#pragma once

#include <stdint.h>

#include "rover/board/motors.h"
#include "rover/control/pid.h"

void drive_start(void);

// Manual mode. A throttle beyond -1..1 is limited, NaN is 0.
void drive_throttles(float left, float right, uint8_t flags);

// PID mode, in rpm.
void drive_setpoints(float left_rpm, float right_rpm, uint8_t flags);

// New gains for both controllers, which begin anew.
void drive_gains(float kp, float kd, float ki);

// Manual mode with both motors off and no setpoints.
void drive_stop(void);

// To be called every DRIVE_TICKS.
#define DRIVE_TICKS 2u
void drive_update(void);

float drive_throttle_of(enum side side);
float drive_setpoint_of(enum side side);
const struct pid *drive_pid_of(enum side side);
