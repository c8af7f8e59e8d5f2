// SPDX-License-Identifier: GPL-2.0-or-later
//
// What an image can be built with, beside the defects. The defaults are the rover as it is documented.
//
// DOC is the seed document (nhorro/ceai2020, intro_se/ISE-ProyectoFinalRover.md, version 0.1.0), G0 the Arduino firmware
// (nhorro/rover-firmware), G1 to G2 the Mbed firmware (nhorro/ceai2020, intro_se/workspace/rover_firmware; G2 is 6058e92).

#pragma once

#include "rover/defects.h"

#ifndef ROVER_IMAGE
#error "compiled once for all images, but it asks for an option: it belongs to ROVER_EACH in rover.mk"
#endif

// --- frames

#ifndef FRAMING_TERM
#define FRAMING_TERM 0 // 1: no length byte, a frame ends with the first newline (DOC)
#endif

// --- what stands in the payloads

#define SCHEMA_V1 1  // speeds as big-endian int16 (DOC, G0, G1)
#define SCHEMA_V1B 2 // speeds as little-endian int16 (G1b)
#define SCHEMA_V2 3  // throttles as little-endian float32 (G2 and its manual)
#ifndef SCHEMA
#define SCHEMA SCHEMA_V2
#endif

#ifndef GENERAL_STATUS
#define GENERAL_STATUS 1 // 0: 0x80 ends before its STATUS byte, as the tables of DOC do
#endif

// --- reports that come by themselves

#define RATES_NONE 0 // 0x80 on request alone (DOC)
#define RATES_G0 1   // 0x82 at 5 Hz, 0x80 at 1 Hz, the first ones after their first period
#define RATES_G2 2   // the manual's table of tasks, as G2 divides its base tick; all fall due on the first tick
#ifndef RATES
#define RATES RATES_G2
#endif
#ifndef PID_REPORT_TICKS
#define PID_REPORT_TICKS 0 // 0x85 every so many ticks; nothing in document, manual or code ever sends it
#endif

// --- hardware

#ifndef BAUD
#define BAUD 115200u
#endif
#ifndef RECEIVE_BY_DMA
#define RECEIVE_BY_DMA 0 // 1: what comes over the line wakes the CPU when the line falls idle, not with each byte
#endif
#ifndef PWM_HZ
#define PWM_HZ 50u // Mbed's default period of 20 ms, which G2 never changes
#endif
