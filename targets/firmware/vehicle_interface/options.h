// SPDX-License-Identifier: GPL-2.0-or-later
//
// What an image can be built with, beside the defects. The figures are those of the original (LMA-FEM-UNICAMP/microAutoware,
// src/HIL/taskControl.h and src/microAutoware/microAutoware.h).

#pragma once

#include "vehicle_interface/defects.h"

#ifndef VEHICLE_IMAGE
#error "compiled once for all images, but it asks for an option: it belongs to VEHICLE_EACH in vehicle_interface.mk"
#endif

#define BAUD 921600u // of both lines

#define AGENT_PINGS 20u
#define AGENT_PING_TICKS 1000u
#define AGENT_TICKS (AGENT_PINGS * AGENT_PING_TICKS)

#define COMMAND_TICKS (DEFECT_ONE_MISS ? 30u : 110u) // how long a command is waited for
#define STATUS_TICKS 100u                            // likewise a status of the simulator
#define MISSES (DEFECT_ONE_MISS ? 1u : 10u)          // of either, in a row, until the mode changes
#define MANUAL_TICKS 60u                             // the rest after each command of the joystick
#define DEBOUNCE_TICKS 1000u
#define REPORT_TICKS 100u         // between two reports of the mode (choice: the original reports it in each turn of its task)
#define AGENT_SILENCE_TICKS 3000u // after which the driving stack counts as lost (choice)

#define STEERING_FACTOR (DEFECT_NO_FACTOR ? 1.0 : 1.2)

// The driving stack's task has a mode of its own, which it is told of by flags, reports, and hands commands on by (V0, V1).
#define OWN_MODE (DEFECT_H6 || DEFECT_FLAG_CLASH || DEFECT_EMERGENCY_KEPT)
