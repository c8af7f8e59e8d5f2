// SPDX-License-Identifier: GPL-2.0-or-later
//
// Carries out what the host commands, counts it, and stops the motors when the host is not heard any more.
// It defines packet_received and packet_rejected of decoder.h.

#pragma once

#include <stdint.h>

// To be called at each tick.
void commands_tick(uint32_t now_us);
