// SPDX-License-Identifier: GPL-2.0-or-later
//
// The pins to the L298N: ENA PB11 (TIM2_CH4), IN1 PB10, IN2 PE15 for the left pair of motors; ENB PE10 (TIM1_CH2N),
// IN3 PE14, IN4 PE12 for the right one.

#pragma once

#include <stdint.h>

enum side { LEFT, RIGHT, SIDES };

void motors_start(void);

// Forwards or backwards, and how much of the time the bridge is on: -1..1; what is beyond counts as all the time, NaN as
// never. It becomes so with the PWM's next period.
void motors_put(enum side side, float throttle);
