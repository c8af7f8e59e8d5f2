// SPDX-License-Identifier: GPL-2.0-or-later
//
// DMA1 and DMA2 (RM0433, section 15.5), and DMAMUX1, which says whose requests a stream serves (section 17.6).

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

#define DMA1 ((volatile dma_t *)0x40020000u)
#define DMA2 ((volatile dma_t *)0x40020400u)

// Channels 0 to 7 serve DMA1, 8 to 15 DMA2.
#define DMAMUX1 ((volatile uint32_t *)0x40020800u)

// RM0433, table 121
enum dma_request {
    REQUEST_ADC1 = 9,
    REQUEST_USART2_RX = 43,
    REQUEST_USART2_TX = 44,
    REQUEST_USART3_RX = 45,
    REQUEST_USART3_TX = 46,
};

#define DMA_CR_EN (1u << 0)
#define DMA_CR_HTIE (1u << 3)
#define DMA_CR_TCIE (1u << 4)
#define DMA_CR_TO_PERIPHERAL (1u << 6)
#define DMA_CR_CIRC (1u << 8)
#define DMA_CR_MINC (1u << 10)
#define DMA_CR_WORDS (2u << 11 | 2u << 13) // otherwise bytes

struct stream {
    volatile dma_t *dma;
    uint8_t number;
    uint8_t request; // an enum dma_request
};

static inline volatile dma_stream_t *stream_of(struct stream stream) { return &stream.dma->S[stream.number]; }

// The five flags of a stream.
static inline void stream_clear(struct stream stream)
{
    static const uint8_t SHIFT[4] = {0, 6, 16, 22};
    stream.dma->IFCR[stream.number / 4] = 0x3Du << SHIFT[stream.number % 4];
}

static inline void stream_stop(struct stream stream)
{
    stream_of(stream)->CR &= ~DMA_CR_EN;
    while (stream_of(stream)->CR & DMA_CR_EN) { // a transfer under way is finished first
    }
}

// Begins to move `count` items; the stream has to be stopped.
static inline void stream_begin(struct stream stream, volatile uint32_t *reg, const volatile void *memory, uint32_t count,
                                uint32_t how)
{
    volatile dma_stream_t *s = stream_of(stream);
    DMAMUX1[stream.number + (stream.dma == DMA2 ? 8 : 0)] = stream.request;
    stream_clear(stream);
    s->PAR = (uint32_t)(uintptr_t)reg;
    s->M0AR = (uint32_t)(uintptr_t)memory;
    s->NDTR = count;
    s->CR = DMA_CR_MINC | how;
    DSB(); // what is to be sent has to be in memory
    s->CR |= DMA_CR_EN;
}
