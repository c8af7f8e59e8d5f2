// SPDX-License-Identifier: GPL-2.0-or-later
//
// Finds the frames in a stream of bytes.

#pragma once

#include <stdint.h>

#include "rover/protocol/codes.h"

void decoder_take(uint8_t byte, uint32_t now_us);

// To be called at each tick: an unfinished frame is forgotten after a second.
void decoder_tick(uint32_t now_us);

// To be defined by whoever wants the frames.
void packet_received(const uint8_t *payload, uint32_t count, uint32_t now_us);
void packet_rejected(enum error error);
