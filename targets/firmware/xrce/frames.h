// SPDX-License-Identifier: GPL-2.0-or-later
//
// Serial frames (OMG DDS-XRCE 1.0, Annex C.1): a flag, two addresses, a length, a payload, its CRC; behind the flag, flags and
// escapes are escaped. As clients and agents in use have it, the CRC is CRC-16/ARC, and over the payload alone
// (eProsima/Micro-XRCE-DDS-Client, stream_framing_protocol.c).

#pragma once

#include <stdint.h>

#include "xrce/sizes.h"

#define XRCE_FRAME (1u + 2u * (4u + XRCE_MTU + 2u)) // bytes, if all is escaped

struct xrce_reader {
    uint8_t body[4 + XRCE_MTU + 2]; // from the source address on, unescaped
    uint32_t count;
    uint8_t in_frame, escaped;
};

// Takes a byte. Returns how long the payload is that it completes, and puts it to `payload`, where it stays until the next
// byte; 0 if it completes none.
uint32_t xrce_frame_take(struct xrce_reader *reader, uint8_t byte, const uint8_t **payload);

// The frame of at most XRCE_MTU bytes; returns how long it is.
uint32_t xrce_frame_make(uint8_t frame[XRCE_FRAME], const uint8_t *payload, uint32_t count);
