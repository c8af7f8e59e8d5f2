// SPDX-License-Identifier: GPL-2.0-or-later
//
// The first newline ends the frame, even if it is one of the payload or of the CRC: nothing is escaped.

#include "rover/protocol/body.h"
#include "rover/protocol/crc.h"

#define MAX_PAYLOAD 64u
#define MAX_BODY (MAX_PAYLOAD + CRC_BYTES)

static uint8_t body[MAX_BODY];
static uint32_t count;

void body_begin(void) { count = 0; }

const uint8_t *body_payload(void) { return body; }

uint32_t body_count(void) { return count - CRC_BYTES; }

// A CRC run over its own two bytes as well comes out as 0.
static enum body end(void) { return count > CRC_BYTES && crc16(body, count) == 0 ? BODY_SOUND : BODY_BAD_CRC; }

enum body body_take(uint8_t byte)
{
    if (byte == NEWLINE)
        return end();
    if (count == MAX_BODY)
        return BODY_BAD_LENGTH;
    body[count++] = byte;
    return BODY_MORE;
}
