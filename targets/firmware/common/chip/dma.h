// SPDX-License-Identifier: GPL-2.0-or-later
//
// DMA1 and which channel serves whom (RM0008, section 13; table 78).

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t CCR;
    uint32_t CNDTR;
    uint32_t CPAR;
    uint32_t CMAR;
    uint32_t reserved;
} dma_channel_t;

typedef struct {
    uint32_t ISR;
    uint32_t IFCR;
    dma_channel_t CHANNEL[7]; // CHANNEL[n - 1] is channel n
} dma_t;

#define DMA1 ((volatile dma_t *)0x40020000u)
#define DMA1_CHANNEL(n) (&DMA1->CHANNEL[(n) - 1])

#define DMA_CCR_EN (1u << 0)
#define DMA_CCR_TCIE (1u << 1)
#define DMA_CCR_HTIE (1u << 2)
#define DMA_CCR_TEIE (1u << 3)
#define DMA_CCR_FROM_MEMORY (1u << 4) // DIR
#define DMA_CCR_CIRC (1u << 5)
#define DMA_CCR_PINC (1u << 6)
#define DMA_CCR_MINC (1u << 7)
#define DMA_CCR_PSIZE_SHIFT 8
#define DMA_CCR_MSIZE_SHIFT 10
#define DMA_CCR_PL_SHIFT 12
#define DMA_CCR_MEM2MEM (1u << 14)

#define DMA_GIF(n) (1u << (4 * ((n) - 1)))
#define DMA_TCIF(n) (2u << (4 * ((n) - 1)))
#define DMA_HTIF(n) (4u << (4 * ((n) - 1)))
#define DMA_TEIF(n) (8u << (4 * ((n) - 1)))

enum dma_request {
    DMA_TIM2_UP = 2,
    DMA_TIM3_UP = 3,
    DMA_USART3_TX = 2,
    DMA_USART3_RX = 3,
    DMA_USART1_TX = 4,
    DMA_USART1_RX = 5,
    DMA_USART2_RX = 6,
    DMA_USART2_TX = 7,
};
