// SPDX-License-Identifier: GPL-2.0-or-later
//
// What the joystick asks for: the calibration is that of the original's author's own.

#pragma once

#include <stdint.h>

#include "vehicle_interface/exchange.h"

// Steering, throttle and brake by the counts of both axes, for MODE_MANUAL.
struct action stick_action(uint16_t x, uint16_t y);
