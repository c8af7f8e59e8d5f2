// SPDX-License-Identifier: GPL-2.0-or-later

#include "xrce/cdr.h"

static void put(struct cdr_writer *out, uint8_t byte)
{
    if (out->count < out->most)
        out->begin[out->count++] = byte;
    else
        out->bad = true;
}

static void put_number(struct cdr_writer *out, uint32_t value, uint32_t size)
{
    while (out->count % size && !out->bad)
        put(out, 0);
    for (uint32_t i = 0; i < size; ++i)
        put(out, (uint8_t)(value >> 8 * i));
}

void cdr_put_u8(struct cdr_writer *out, uint8_t value) { put(out, value); }

void cdr_put_u16(struct cdr_writer *out, uint16_t value) { put_number(out, value, 2); }

void cdr_put_u32(struct cdr_writer *out, uint32_t value) { put_number(out, value, 4); }

union bits {
    uint32_t word;
    float real;
};

void cdr_put_float(struct cdr_writer *out, float value) { put_number(out, (union bits){.real = value}.word, 4); }

void cdr_put_text(struct cdr_writer *out, const char *text)
{
    uint32_t count = 0;
    while (text[count])
        ++count;
    cdr_put_u32(out, count + 1);
    cdr_put_octets(out, (const uint8_t *)text, count + 1);
}

void cdr_put_octets(struct cdr_writer *out, const uint8_t *octets, uint32_t count)
{
    for (uint32_t i = 0; i < count; ++i)
        put(out, octets[i]);
}

void cdr_put_id(struct cdr_writer *out, uint16_t id)
{
    put(out, (uint8_t)(id >> 8));
    put(out, (uint8_t)id);
}

static uint8_t get(struct cdr_reader *in)
{
    if (in->at < in->count)
        return in->begin[in->at++];
    in->bad = true;
    return 0;
}

static uint32_t get_number(struct cdr_reader *in, uint32_t size)
{
    in->at += (size - in->at % size) % size;
    uint32_t value = 0;
    for (uint32_t i = 0; i < size; ++i) {
        uint32_t byte = get(in);
        value = in->big_endian ? value << 8 | byte : value | byte << 8 * i;
    }
    return in->bad ? 0 : value;
}

uint8_t cdr_get_u8(struct cdr_reader *in) { return get(in); }

uint16_t cdr_get_u16(struct cdr_reader *in) { return (uint16_t)get_number(in, 2); }

uint32_t cdr_get_u32(struct cdr_reader *in) { return get_number(in, 4); }

float cdr_get_float(struct cdr_reader *in) { return (union bits){.word = get_number(in, 4)}.real; }

uint16_t cdr_get_id(struct cdr_reader *in)
{
    uint16_t high = get(in);
    return (uint16_t)(high << 8 | get(in));
}
