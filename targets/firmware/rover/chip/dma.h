// SPDX-License-Identifier: GPL-2.0-or-later
//
// DMA1 and its streams (RM0410, section 8), for bytes between memory and one peripheral's register.

#pragma once

#include <stdint.h>

#include "chip/cpu.h"

typedef struct {
    uint32_t CR;
    uint32_t NDTR;
    uint32_t PAR;
    uint32_t M0AR;
    uint32_t M1AR;
    uint32_t FCR;
} dma_stream_t;

typedef struct {
    uint32_t ISR[2]; // of streams 0 to 3 and 4 to 7
    uint32_t IFCR[2];
    dma_stream_t S[8];
} dma_t;

#define DMA1 ((volatile dma_t *)0x40026000u)

#define DMA_CR_EN (1u << 0)
#define DMA_CR_TCIE (1u << 4)
#define DMA_CR_TO_PERIPHERAL (1u << 6)
#define DMA_CR_CIRC (1u << 8)
#define DMA_CR_MINC (1u << 10)
#define DMA_CR_CHSEL_SHIFT 25

// The five flags of a stream.
static inline void dma_clear(unsigned stream)
{
    static const uint8_t SHIFT[4] = {0, 6, 16, 22};
    DMA1->IFCR[stream / 4] = 0x3Du << SHIFT[stream % 4];
}

static inline void dma_stop(unsigned stream)
{
    DMA1->S[stream].CR &= ~DMA_CR_EN;
    while (DMA1->S[stream].CR & DMA_CR_EN) { // a transfer under way is finished first
    }
}

// Begins to move `count` bytes; the stream has to be stopped.
static inline void dma_begin(unsigned stream, unsigned channel, volatile uint32_t *reg, const volatile void *memory,
                             uint32_t count, uint32_t how)
{
    volatile dma_stream_t *s = &DMA1->S[stream];
    dma_clear(stream);
    s->PAR = (uint32_t)(uintptr_t)reg;
    s->M0AR = (uint32_t)(uintptr_t)memory;
    s->NDTR = count;
    s->CR = channel << DMA_CR_CHSEL_SHIFT | DMA_CR_MINC | how;
    DSB(); // what is to be sent has to be in memory
    s->CR |= DMA_CR_EN;
}
