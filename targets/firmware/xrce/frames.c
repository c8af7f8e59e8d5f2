// SPDX-License-Identifier: GPL-2.0-or-later

#include "xrce/frames.h"

#include <stdbool.h>

#define FLAG 0x7Eu
#define ESCAPE 0x7Du
#define TURNED 0x20u // what an escaped byte is xored with
#define ADDRESS 0u   // of both ends
#define HEADER_BYTES 4u
#define CRC_BYTES 2u
#define POLYNOMIAL 0xA001u // 8005 hex, reflected

static uint16_t crc_of(const uint8_t *data, uint32_t count)
{
    uint16_t crc = 0;
    for (uint32_t i = 0; i < count; ++i) {
        crc ^= data[i];
        for (int bit = 0; bit < 8; ++bit)
            crc = (uint16_t)(crc >> 1 ^ (crc & 1 ? POLYNOMIAL : 0));
    }
    return crc;
}

static uint32_t length_of(const struct xrce_reader *reader) { return reader->body[2] | (uint32_t)reader->body[3] << 8; }

// Whether the frame, as far as it has come, may still become one.
static bool sound(const struct xrce_reader *reader)
{
    if (reader->count >= 2 && reader->body[1] != ADDRESS)
        return false;
    return reader->count < HEADER_BYTES || length_of(reader) <= XRCE_MTU;
}

static void begin(struct xrce_reader *reader, bool in_frame)
{
    reader->count = 0;
    reader->escaped = 0;
    reader->in_frame = in_frame;
}

uint32_t xrce_frame_take(struct xrce_reader *reader, uint8_t byte, const uint8_t **payload)
{
    if (byte == FLAG) {
        begin(reader, true);
        return 0;
    }
    if (!reader->in_frame)
        return 0;
    if (byte == ESCAPE) {
        reader->escaped = 1;
        return 0;
    }
    reader->body[reader->count++] = reader->escaped ? byte ^ TURNED : byte;
    reader->escaped = 0;
    if (!sound(reader)) {
        begin(reader, false);
        return 0;
    }
    if (reader->count < HEADER_BYTES || reader->count < HEADER_BYTES + length_of(reader) + CRC_BYTES)
        return 0;
    uint32_t length = length_of(reader);
    begin(reader, false);
    *payload = reader->body + HEADER_BYTES;
    const uint8_t *crc = *payload + length;
    return crc_of(*payload, length) == (crc[0] | crc[1] << 8) ? length : 0;
}

static uint32_t put(uint8_t *frame, uint32_t count, uint8_t byte)
{
    if (byte == FLAG || byte == ESCAPE) {
        frame[count++] = ESCAPE;
        byte ^= TURNED;
    }
    frame[count++] = byte;
    return count;
}

uint32_t xrce_frame_make(uint8_t frame[XRCE_FRAME], const uint8_t *payload, uint32_t count)
{
    const uint8_t header[HEADER_BYTES] = {ADDRESS, ADDRESS, (uint8_t)count, (uint8_t)(count >> 8)};
    uint16_t crc = crc_of(payload, count);
    uint32_t size = 0;
    frame[size++] = FLAG;
    for (uint32_t i = 0; i < HEADER_BYTES; ++i)
        size = put(frame, size, header[i]);
    for (uint32_t i = 0; i < count; ++i)
        size = put(frame, size, payload[i]);
    size = put(frame, size, (uint8_t)crc);
    return put(frame, size, (uint8_t)(crc >> 8));
}
