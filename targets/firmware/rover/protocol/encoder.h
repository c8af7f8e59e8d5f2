// SPDX-License-Identifier: GPL-2.0-or-later
//
// Puts a frame around a payload, and sends it.

#pragma once

#include <stdint.h>

#define MAX_REPORT 68u

void encoder_send(const uint8_t *payload, uint32_t count);
