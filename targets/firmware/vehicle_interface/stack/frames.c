// SPDX-License-Identifier: GPL-2.0-or-later

#include "vehicle_interface/stack/frames.h"

#include "vehicle_interface/stack/crc.h"

#define FLAG 0x7Eu
#define ESCAPE 0x7Du
#define TURNED 0x20u // what an escaped byte is xored with
#define ADDRESS 0u   // of both ends, as in the original's client
#define HEADER_BYTES 4u
#define CRC_BYTES 2u

static uint32_t length_of(const struct frame_reader *reader) { return reader->body[2] | (uint32_t)reader->body[3] << 8; }

// Whether the frame, as far as it has come, may still become one.
static int sound(const struct frame_reader *reader)
{
    if (reader->count >= 2 && reader->body[1] != ADDRESS)
        return 0;
    return reader->count < HEADER_BYTES || length_of(reader) <= MAX_PAYLOAD;
}

static int crc_right(const struct frame_reader *reader, uint32_t length)
{
    uint16_t crc = 0;
    for (uint32_t i = 0; i < length; ++i)
        crc = crc_add(crc, reader->body[HEADER_BYTES + i]);
    const uint8_t *end = reader->body + HEADER_BYTES + length;
    return crc == (end[0] | end[1] << 8);
}

static void begin(struct frame_reader *reader, uint8_t in_frame)
{
    reader->count = 0;
    reader->escaped = 0;
    reader->in_frame = in_frame;
}

uint32_t frame_take(struct frame_reader *reader, uint8_t byte, const uint8_t **payload)
{
    if (byte == FLAG) {
        begin(reader, 1);
        return 0;
    }
    if (!reader->in_frame)
        return 0;
    if (reader->escaped) {
        byte ^= TURNED;
        reader->escaped = 0;
    } else if (byte == ESCAPE) {
        reader->escaped = 1;
        return 0;
    }
    reader->body[reader->count++] = byte;
    if (!sound(reader)) {
        begin(reader, 0);
        return 0;
    }
    if (reader->count < HEADER_BYTES || reader->count < HEADER_BYTES + length_of(reader) + CRC_BYTES)
        return 0;
    uint32_t length = length_of(reader);
    begin(reader, 0);
    *payload = reader->body + HEADER_BYTES;
    return crc_right(reader, length) ? length : 0;
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

uint32_t frame_make(uint8_t frame[MAX_FRAME], const uint8_t *payload, uint32_t count)
{
    const uint8_t header[HEADER_BYTES] = {ADDRESS, ADDRESS, (uint8_t)count, (uint8_t)(count >> 8)};
    uint16_t crc = 0;
    uint32_t size = 0;
    frame[size++] = FLAG;
    for (uint32_t i = 0; i < HEADER_BYTES; ++i)
        size = put(frame, size, header[i]);
    for (uint32_t i = 0; i < count; ++i) {
        crc = crc_add(crc, payload[i]);
        size = put(frame, size, payload[i]);
    }
    size = put(frame, size, (uint8_t)crc);
    return put(frame, size, (uint8_t)(crc >> 8));
}
