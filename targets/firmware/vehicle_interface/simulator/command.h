// SPDX-License-Identifier: GPL-2.0-or-later
//
// The frame that commands the simulator: a letter before each field, floats in the order of memory.

#pragma once

#include "vehicle_interface/board/simulator_line.h"
#include "vehicle_interface/exchange.h"

void command_make(uint8_t frame[COMMAND_BYTES], const struct action *action);
