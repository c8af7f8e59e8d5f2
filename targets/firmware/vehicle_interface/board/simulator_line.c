// SPDX-License-Identifier: GPL-2.0-or-later
//
// What comes goes round in a buffer without end, and is read whenever the line falls silent or half of the buffer is full.
// The original takes blocks of 22 bytes instead, and gives up at the first error of the line (HAL_UART_IRQHandler aborts the
// transfer, and nothing begins it anew); and a frame that finds another one under way is lost there (HAL_BUSY).

#include "vehicle_interface/board/simulator_line.h"

#include <stdbool.h>

#include "vehicle_interface/board/clock.h"
#include "vehicle_interface/chip/dma.h"
#include "vehicle_interface/chip/gpio.h"
#include "vehicle_interface/chip/irq.h"
#include "vehicle_interface/chip/rcc.h"
#include "vehicle_interface/chip/usart.h"
#include "vehicle_interface/kernel/kernel.h"
#include "vehicle_interface/options.h"

#define TX 5 // of port D
#define RX 3 // of port A
#define AF_USART2 7
#define ROOM (DEFECT_H2 ? STATUS_BYTES : 256u)

static const struct stream RX_STREAM = {DMA2, 1, REQUEST_USART2_RX};
static const struct stream TX_STREAM = {DMA2, 2, REQUEST_USART2_TX};

static volatile uint8_t received[ROOM];
static uint8_t sending[COMMAND_BYTES], waiting[COMMAND_BYTES];
static bool waits;
static uint32_t taken;

static void listen(void)
{
    uint32_t how = DEFECT_H2 ? DMA_CR_TCIE : DMA_CR_CIRC | DMA_CR_HTIE | DMA_CR_TCIE;
    stream_begin(RX_STREAM, &USART2->RDR, received, ROOM, how);
}

static void take_all(void)
{
    uint32_t end = (ROOM - stream_of(RX_STREAM)->NDTR) % ROOM; // NDTR counts down
    if (end < taken) {
        simulator_line_received(received + taken, ROOM - taken);
        taken = 0;
    }
    if (end > taken)
        simulator_line_received(received + taken, end - taken);
    taken = end;
}

void DMA2_Stream1_IRQHandler(void)
{
    stream_clear(RX_STREAM);
    if (DEFECT_H2) {
        simulator_line_received(received, STATUS_BYTES);
        listen();
    } else {
        take_all();
    }
}

void USART2_IRQHandler(void)
{
    uint32_t flags = USART2->ISR;
    USART2->ICR = flags & (USART_ERRORS | USART_IDLE);
    if (DEFECT_DIES_ON_ERROR && flags & USART_ERRORS) {
        USART2->CR3 &= ~(USART_CR3_DMAR | USART_CR3_EIE);
        stream_stop(RX_STREAM);
    } else if (!DEFECT_H2) {
        take_all();
    }
}

void simulator_line_start(void)
{
    RCC->AHB4ENR |= RCC_AHB4_GPIO('A') | RCC_AHB4_GPIO('D');
    RCC->AHB1ENR |= RCC_AHB1_DMA2;
    RCC->APB1LENR |= RCC_APB1L_USART2;
    (void)RCC->APB1LENR;
    pin_pull_up(GPIO('A'), RX); // a line that is not connected is silent
    pin_alternate(GPIO('D'), TX, AF_USART2);
    pin_alternate(GPIO('A'), RX, AF_USART2);
    USART2->BRR = (PCLK1_HZ + BAUD / 2) / BAUD;
    USART2->CR3 = USART_CR3_DMAR | USART_CR3_DMAT | USART_CR3_EIE;
    listen();
    USART2->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE | (DEFECT_H2 ? 0 : USART_CR1_IDLEIE);
    irq_enable_line(USART2_IRQ, LEVEL_USART2);
    irq_enable_line(DMA2_STREAM1_IRQ, LEVEL_DMA);
    irq_enable_line(DMA2_STREAM2_IRQ, LEVEL_DMA);
}

static void begin(const uint8_t frame[COMMAND_BYTES])
{
    for (uint32_t i = 0; i < COMMAND_BYTES; ++i)
        sending[i] = frame[i];
    stream_begin(TX_STREAM, &USART2->TDR, sending, COMMAND_BYTES - DEFECT_NO_PADDING, DMA_CR_TO_PERIPHERAL | DMA_CR_TCIE);
}

void DMA2_Stream2_IRQHandler(void)
{
    stream_clear(TX_STREAM);
    if (waits)
        begin(waiting);
    waits = false;
}

void simulator_line_send(const uint8_t frame[COMMAND_BYTES])
{
    kernel_lock(); // the interrupt of a transfer that ends now would miss what waits
    waits = stream_of(TX_STREAM)->CR & DMA_CR_EN; // it stops by itself at the end
    if (waits)
        for (uint32_t i = 0; i < COMMAND_BYTES; ++i)
            waiting[i] = frame[i];
    else
        begin(frame);
    kernel_unlock();
}
