// SPDX-License-Identifier: GPL-2.0-or-later
//
// Frames of the stand-in link (docs/autoware/stand-in-link.md): a flag, two addresses, a length, a payload and its CRC; behind
// the flag, flags and escapes are escaped. They are those of Micro XRCE-DDS's serial stream, so that an agent can take over.

#pragma once

#include <stdint.h>

#define MAX_PAYLOAD 64u
#define MAX_FRAME (1u + 2u * (4u + MAX_PAYLOAD + 2u)) // if all is escaped

struct frame_reader {
    uint8_t body[4 + MAX_PAYLOAD + 2]; // from the source address on, unescaped
    uint8_t count;
    uint8_t in_frame, escaped;
};

// Takes a byte. Returns how long the payload is that it completes, and puts it to `payload`; 0 if it completes none.
uint32_t frame_take(struct frame_reader *reader, uint8_t byte, const uint8_t **payload);

// The frame of 1 to MAX_PAYLOAD bytes; returns how long it is.
uint32_t frame_make(uint8_t frame[MAX_FRAME], const uint8_t *payload, uint32_t count);
