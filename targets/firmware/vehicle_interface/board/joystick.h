// SPDX-License-Identifier: GPL-2.0-or-later
//
// The joystick: X on PF12 (ADC1_INP6), Y on PF11 (ADC1_INP2), as the original's code has them; its document's schematic has
// them the other way round. The switch is on PF13, at ground while it is pressed; it acts when it is let go.

#pragma once

#include <stdint.h>

void joystick_start(void);

// Of 16 bits, converted without end.
uint16_t joystick_x(void);
uint16_t joystick_y(void);

// To be defined by whoever is to know; called from the interrupt of each rising edge, bouncing included.
void joystick_released(void);
