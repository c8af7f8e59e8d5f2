// SPDX-License-Identifier: GPL-2.0-or-later
//
// A ring of bytes between one writer and one reader, one of them an interrupt handler: each moves its own end only, so
// neither has to lock the other out.

#pragma once

#include <stdbool.h>
#include <stdint.h>

#define RING_BYTES 1024u // a power of two

struct ring {
    volatile uint32_t head, tail; // run freely; their difference is the fill
    uint8_t bytes[RING_BYTES];
};

static inline uint32_t ring_fill(const struct ring *ring) { return ring->head - ring->tail; }

static inline bool ring_put(struct ring *ring, uint8_t byte)
{
    if (ring_fill(ring) == RING_BYTES)
        return false;
    ring->bytes[ring->head % RING_BYTES] = byte;
    __asm volatile("" ::: "memory"); // the byte before the index that shows it
    ++ring->head;
    return true;
}

static inline bool ring_get(struct ring *ring, uint8_t *byte)
{
    if (ring_fill(ring) == 0)
        return false;
    *byte = ring->bytes[ring->tail % RING_BYTES];
    __asm volatile("" ::: "memory");
    ++ring->tail;
    return true;
}
