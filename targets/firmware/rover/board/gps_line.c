// SPDX-License-Identifier: GPL-2.0-or-later
//
// DMA goes round in a buffer without end; whoever reads follows it. There is room for a quarter of a second.

#include "rover/board/gps_line.h"

#include "rover/board/clock.h"
#include "rover/chip/dma.h"
#include "rover/chip/gpio.h"
#include "rover/chip/rcc.h"
#include "rover/chip/usart.h"

#define TX 5
#define RX 6
#define AF_USART2 7
#define GPS_BAUD 9600u
#define RX_STREAM 5 // USART2_RX is its channel 4 (RM0410, table 27)
#define RX_CHANNEL 4
#define ROOM 256u

static volatile uint8_t received[ROOM];
static uint32_t taken;

void gps_line_start(void)
{
    RCC->AHB1ENR |= RCC_AHB1_GPIO('D') | RCC_AHB1_DMA1;
    RCC->APB1ENR |= RCC_APB1_USART2;
    pin_pull_up(GPIO('D'), RX);
    pin_alternate(GPIO('D'), TX, AF_USART2);
    pin_alternate(GPIO('D'), RX, AF_USART2);
    USART2->BRR = (PCLK1_HZ + GPS_BAUD / 2) / GPS_BAUD;
    USART2->CR3 = USART_CR3_DMAR | USART_CR3_OVRDIS;
    USART2->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE;
    dma_begin(RX_STREAM, RX_CHANNEL, &USART2->RDR, received, ROOM, DMA_CR_CIRC);
}

bool gps_line_get(uint8_t *byte)
{
    uint32_t end = ROOM - DMA1->S[RX_STREAM].NDTR; // NDTR counts down
    if (taken == end % ROOM)
        return false;
    *byte = received[taken];
    taken = (taken + 1) % ROOM;
    return true;
}
