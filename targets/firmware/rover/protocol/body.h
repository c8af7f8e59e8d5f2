// SPDX-License-Identifier: GPL-2.0-or-later
//
// What stands behind the sync word of a frame. There are two ways to say where it ends, a source file for each:
//
//   body_len.c    length, payload, CRC high, CRC low, newline      (all firmware)
//   body_term.c   payload, CRC high, CRC low, newline              (DOC, which no firmware ever did)

#pragma once

#include <stdint.h>

#define NEWLINE 0x0Au
#define CRC_BYTES 2u

enum body { BODY_MORE, BODY_SOUND, BODY_BAD_LENGTH, BODY_BAD_CRC, BODY_BAD_TERMINATOR };

void body_begin(void);
enum body body_take(uint8_t byte);

// After BODY_SOUND. What lies behind the payload is what earlier frames left there.
const uint8_t *body_payload(void);
uint32_t body_count(void);
