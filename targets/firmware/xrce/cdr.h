// SPDX-License-Identifier: GPL-2.0-or-later
//
// CDR (OMG DDS-XTypes 1.3, 7.4): values one behind the other, numbers at multiples of their own size, counted from where the
// data begin; no size here is over 4 bytes, so that XCDR1 and XCDR2 are the same. What does not fit, or is not there, is `bad`.

#pragma once

#include <stdbool.h>
#include <stdint.h>

struct cdr_writer {
    uint8_t *begin;
    uint32_t count, most; // bytes written, and room
    bool bad;
};

struct cdr_reader {
    const uint8_t *begin;
    uint32_t at, count;
    bool big_endian, bad;
};

// Written is little-endian.
void cdr_put_u8(struct cdr_writer *out, uint8_t value);
void cdr_put_u16(struct cdr_writer *out, uint16_t value);
void cdr_put_u32(struct cdr_writer *out, uint32_t value);
void cdr_put_float(struct cdr_writer *out, float value);
void cdr_put_text(struct cdr_writer *out, const char *text);

// Bytes as they are; and the two octets of an id, high one first (7.7.1 of DDS-XRCE).
void cdr_put_octets(struct cdr_writer *out, const uint8_t *octets, uint32_t count);
void cdr_put_id(struct cdr_writer *out, uint16_t id);

// Nothing is 0.
uint8_t cdr_get_u8(struct cdr_reader *in);
uint16_t cdr_get_u16(struct cdr_reader *in);
uint32_t cdr_get_u32(struct cdr_reader *in);
float cdr_get_float(struct cdr_reader *in);
uint16_t cdr_get_id(struct cdr_reader *in);
