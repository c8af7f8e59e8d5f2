// SPDX-License-Identifier: GPL-2.0-or-later
//
// What interrupts hand to the control task: presses of the joystick, and statuses of the simulator.

#pragma once

#include "vehicle_interface/exchange.h"

// The latest; BOARD_STATUS says that there is a new one. With the kernel's lock held.
struct status status_received(void);
