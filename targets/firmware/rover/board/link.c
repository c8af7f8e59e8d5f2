// SPDX-License-Identifier: GPL-2.0-or-later
//
// What comes is taken byte by byte, for it may be answered at once; with RECEIVE_BY_DMA it is looked for when the line falls idle,
// and whenever something else has woken the CPU, a tick at the latest. What goes is fetched from its ring by DMA, as much at a time as lies there in one piece.

#include "rover/board/link.h"

#include "ring.h"
#include "rover/board/clock.h"
#include "rover/board/time.h"
#include "rover/chip/dma.h"
#include "rover/chip/gpio.h"
#include "rover/chip/irq.h"
#include "rover/chip/rcc.h"
#include "rover/chip/usart.h"
#include "rover/options.h"

#define TX 8
#define RX 9
#define AF_USART3 7
#define LEVEL 1
#define TX_STREAM 3 // USART3_TX is its channel 4 (RM0410, table 27)
#define TX_CHANNEL 4
#define RX_STREAM 1 // USART3_RX is its channel 4 (the same table)
#define RX_CHANNEL 4

// What may wait: as much as the ring holds, or what Mbed OS lets wait (its uart-serial-rxbuf-size).
#define RECEIVE_BYTES (DEFECT_POLLED ? 256u : RING_BYTES)

static struct ring received, to_send;
static volatile uint32_t sending; // bytes at the tail of to_send that DMA has been given

void USART3_IRQHandler(void)
{
    if (RECEIVE_BY_DMA) {
        USART3->ICR = USART_ICR_IDLECF; // the CPU is awake now: what came is looked for
        DSB();                          // the flag has fallen before the handler is left
        return;
    }
    uint32_t flags = USART3->ISR;
    if (flags & USART_ISR_ORE)
        USART3->ICR = USART_ICR_ORECF; // a byte is lost; its frame fails at the CRC
    if (flags & USART_ISR_RXNE) {
        uint8_t byte = (uint8_t)USART3->RDR;
        if (ring_fill(&received) < RECEIVE_BYTES)
            ring_put(&received, byte);
    }
}

// DMA goes round in the ring and never waits, so who reads looks at least twice in the time of a round: 89 ms at 115200 baud.
_Static_assert(!RECEIVE_BY_DMA || !(DEFECT_POLLED || DEFECT_SLOW_START), "these leave bytes in the ring for too long");
_Static_assert(!RECEIVE_BY_DMA || RING_BYTES * 10u * TICK_HZ >= 2u * BAUD, "the ring is too small for the rate");

static void follow_dma(void)
{
    uint32_t end = RING_BYTES - DMA1->S[RX_STREAM].NDTR; // counts down when a byte is fetched, some cycles before it is stored
    DSB();
    received.head += (end - received.head) % RING_BYTES;
}

static void send_next_piece(void)
{
    uint32_t begin = to_send.tail % RING_BYTES, count = ring_fill(&to_send);
    sending = count < RING_BYTES - begin ? count : RING_BYTES - begin;
    if (sending)
        dma_begin(TX_STREAM, TX_CHANNEL, &USART3->TDR, to_send.bytes + begin, sending, DMA_CR_TO_PERIPHERAL | DMA_CR_TCIE);
}

void DMA1_Stream3_IRQHandler(void)
{
    dma_clear(TX_STREAM);
    to_send.tail += sending;
    send_next_piece();
}

void link_start(void)
{
    RCC->AHB1ENR |= RCC_AHB1_GPIO('D') | RCC_AHB1_DMA1;
    RCC->APB1ENR |= RCC_APB1_USART3;
    pin_pull_up(GPIO('D'), RX); // a line that is not connected is silent
    pin_alternate(GPIO('D'), TX, AF_USART3);
    pin_alternate(GPIO('D'), RX, AF_USART3);
    USART3->BRR = (PCLK1_HZ + BAUD / 2) / BAUD;
    if (RECEIVE_BY_DMA) {
        USART3->CR3 = USART_CR3_DMAT | USART_CR3_DMAR | USART_CR3_OVRDIS;
        USART3->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE | USART_CR1_IDLEIE;
        dma_begin(RX_STREAM, RX_CHANNEL, &USART3->RDR, received.bytes, RING_BYTES, DMA_CR_CIRC);
    } else {
        USART3->CR3 = USART_CR3_DMAT;
        USART3->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE | USART_CR1_RXNEIE;
    }
    irq_enable_line(USART3_IRQ, LEVEL);
    irq_enable_line(DMA1_STREAM3_IRQ, LEVEL);
}

uint32_t link_waiting(void)
{
    if (RECEIVE_BY_DMA)
        follow_dma();
    return ring_fill(&received);
}

bool link_get(uint8_t *byte)
{
    if (RECEIVE_BY_DMA)
        follow_dma();
    return ring_get(&received, byte);
}

void link_send(const uint8_t *data, uint32_t count)
{
    if (RING_BYTES - ring_fill(&to_send) < count)
        return;
    for (uint32_t i = 0; i < count; ++i)
        ring_put(&to_send, data[i]);
    if (sending == 0) // else the interrupt goes on with it
        send_next_piece();
}
