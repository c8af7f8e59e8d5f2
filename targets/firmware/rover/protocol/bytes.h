// SPDX-License-Identifier: GPL-2.0-or-later
//
// Numbers as they stand in payloads: the lowest byte first, as in this chip's memory.

#pragma once

#include <stdint.h>

static inline float get_float(const uint8_t *at)
{
    float value;
    __builtin_memcpy(&value, at, sizeof value);
    return value;
}

// Each returns where the next one goes.

static inline uint8_t *put_bytes(uint8_t *at, const void *from, uint32_t count)
{
    for (uint32_t i = 0; i < count; ++i)
        *at++ = ((const uint8_t *)from)[i];
    return at;
}

static inline uint8_t *put_float(uint8_t *at, float value) { return put_bytes(at, &value, sizeof value); }

static inline uint8_t *put_u32(uint8_t *at, uint32_t value) { return put_bytes(at, &value, sizeof value); }
