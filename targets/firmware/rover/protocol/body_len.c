// SPDX-License-Identifier: GPL-2.0-or-later
//
// A length byte says where the payload ends; a newline in it means nothing.

#include "rover/protocol/body.h"
#include "rover/protocol/crc.h"

#define MAX_PAYLOAD 96u

static enum { LENGTH, PAYLOAD, CRC_HIGH, CRC_LOW, TERMINATOR } state;
static uint8_t payload[MAX_PAYLOAD + 1]; // and the zero that all firmware puts behind
static uint32_t length, count;
static uint16_t crc;

void body_begin(void) { state = LENGTH; }

const uint8_t *body_payload(void) { return payload; }

uint32_t body_count(void) { return length; }

static enum body take_length(uint8_t byte)
{
    if (byte == 0 || byte > MAX_PAYLOAD)
        return BODY_BAD_LENGTH;
    length = byte;
    count = 0;
    state = PAYLOAD;
    return BODY_MORE;
}

static void take_payload(uint8_t byte)
{
    payload[count++] = byte;
    if (count == length) {
        payload[count] = 0;
        state = CRC_HIGH;
    }
}

static enum body take_crc_low(uint8_t byte)
{
    state = TERMINATOR;
    return (crc | byte) == crc16(payload, length) ? BODY_MORE : BODY_BAD_CRC;
}

enum body body_take(uint8_t byte)
{
    switch (state) {
    case LENGTH:
        return take_length(byte);
    case PAYLOAD:
        take_payload(byte);
        return BODY_MORE;
    case CRC_HIGH:
        crc = (uint16_t)(byte << 8);
        state = CRC_LOW;
        return BODY_MORE;
    case CRC_LOW:
        return take_crc_low(byte);
    default:
        return byte == NEWLINE ? BODY_SOUND : BODY_BAD_TERMINATOR;
    }
}
