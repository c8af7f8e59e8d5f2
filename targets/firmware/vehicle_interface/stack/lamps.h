// SPDX-License-Identifier: GPL-2.0-or-later
//
// Turn indicators and hazard lights: 90 flashes a minute, lit first; hazard lights rule over turn indicators (choice: the
// original's document asks for both, its code has neither).

#pragma once

#include <stdint.h>

// The values of autoware_auto_vehicle_msgs. 0, no command, and unknown ones change nothing.
enum { TURN_DISABLE = 1, TURN_LEFT = 2, TURN_RIGHT = 3 };
enum { HAZARD_DISABLE = 1, HAZARD_ENABLE = 2 };

void lamps_turn(uint8_t command, uint32_t tick);
void lamps_hazard(uint8_t command, uint32_t tick);

uint8_t lamps_turn_report(void);
uint8_t lamps_hazard_report(void);

// Switches the lamps as it is due; returns in how many ticks it wants to be called again at the latest.
uint32_t lamps_update(uint32_t tick);
