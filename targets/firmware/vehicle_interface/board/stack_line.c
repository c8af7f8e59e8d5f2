// SPDX-License-Identifier: GPL-2.0-or-later
//
// What comes goes round in a buffer without end, as in the original; whoever reads follows it. What goes is fetched from its ring
// as much at a time as lies there in one piece.

#include "vehicle_interface/board/stack_line.h"

#include "ring.h"
#include "vehicle_interface/board/clock.h"
#include "vehicle_interface/chip/dma.h"
#include "vehicle_interface/chip/gpio.h"
#include "vehicle_interface/chip/irq.h"
#include "vehicle_interface/chip/rcc.h"
#include "vehicle_interface/chip/usart.h"
#include "vehicle_interface/kernel/kernel.h"
#include "vehicle_interface/options.h"

#define TX 8
#define RX 9
#define AF_USART3 7
#define ROOM 2048u

static const struct stream RX_STREAM = {DMA1, 0, REQUEST_USART3_RX};
static const struct stream TX_STREAM = {DMA1, 1, REQUEST_USART3_TX};

static volatile uint8_t received[ROOM];
static uint32_t taken;
static struct ring to_send;
static volatile uint32_t sending; // bytes at the tail of to_send that DMA has been given

void USART3_IRQHandler(void)
{
    uint32_t flags = USART3->ISR;
    USART3->ICR = flags & (USART_ERRORS | USART_IDLE); // what an error spoils fails at its CRC
    if (flags & USART_IDLE)
        stack_line_silent();
}

static void send_next_piece(void)
{
    uint32_t begin = to_send.tail % RING_BYTES, count = ring_fill(&to_send);
    sending = count < RING_BYTES - begin ? count : RING_BYTES - begin;
    if (sending)
        stream_begin(TX_STREAM, &USART3->TDR, to_send.bytes + begin, sending, DMA_CR_TO_PERIPHERAL | DMA_CR_TCIE);
}

void DMA1_Stream1_IRQHandler(void)
{
    stream_clear(TX_STREAM);
    to_send.tail += sending;
    send_next_piece();
}

void stack_line_start(void)
{
    RCC->AHB4ENR |= RCC_AHB4_GPIO('D');
    RCC->AHB1ENR |= RCC_AHB1_DMA1;
    RCC->APB1LENR |= RCC_APB1L_USART3;
    (void)RCC->APB1LENR;
    pin_pull_up(GPIO('D'), RX); // a line that is not connected is silent
    pin_alternate(GPIO('D'), TX, AF_USART3);
    pin_alternate(GPIO('D'), RX, AF_USART3);
    USART3->BRR = (PCLK1_HZ + BAUD / 2) / BAUD;
    USART3->CR3 = USART_CR3_DMAR | USART_CR3_DMAT | USART_CR3_EIE;
    stream_begin(RX_STREAM, &USART3->RDR, received, ROOM, DMA_CR_CIRC);
    USART3->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE | USART_CR1_IDLEIE;
    irq_enable_line(USART3_IRQ, LEVEL_USART3);
    irq_enable_line(DMA1_STREAM1_IRQ, LEVEL_DMA);
}

bool stack_line_get(uint8_t *byte)
{
    uint32_t end = ROOM - stream_of(RX_STREAM)->NDTR; // NDTR counts down
    if (taken == end % ROOM)
        return false;
    *byte = received[taken];
    taken = (taken + 1) % ROOM;
    return true;
}

void stack_line_send(const uint8_t *data, uint32_t count)
{
    if (RING_BYTES - ring_fill(&to_send) < count)
        return;
    for (uint32_t i = 0; i < count; ++i)
        ring_put(&to_send, data[i]);
    kernel_lock(); // the interrupt of a transfer that ends now would begin the same piece
    if (sending == 0)
        send_next_piece();
    kernel_unlock();
}
