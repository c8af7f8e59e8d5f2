// SPDX-License-Identifier: GPL-2.0-or-later
//
// What the general report says: how many packets came, and what became of the last one.

#pragma once

#include <stdint.h>

struct telemetry {
    uint8_t accepted, rejected; // wrap at 256
    uint8_t last_opcode, last_error;
};

extern struct telemetry telemetry;
