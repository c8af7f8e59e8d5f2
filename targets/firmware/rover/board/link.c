// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/board/link.h"

#include "ring.h"
#include "rover/board/clock.h"
#include "rover/chip/gpio.h"
#include "rover/chip/irq.h"
#include "rover/chip/rcc.h"
#include "rover/chip/usart.h"
#include "rover/options.h"

#define TX 8
#define RX 9
#define AF_USART3 7
#define LEVEL 1

// What may wait: as much as the ring holds, or what Mbed OS lets wait (its uart-serial-rxbuf-size).
#define RECEIVE_BYTES (DEFECT_POLLED ? 256u : RING_BYTES)

static struct ring received, to_send;

void USART3_IRQHandler(void)
{
    uint32_t flags = USART3->ISR;
    if (flags & USART_ISR_ORE)
        USART3->ICR = USART_ICR_ORECF; // a byte is lost; its frame fails at the CRC
    if (flags & USART_ISR_RXNE) {
        uint8_t byte = (uint8_t)USART3->RDR;
        if (ring_fill(&received) < RECEIVE_BYTES)
            ring_put(&received, byte);
    }
    if (flags & USART_ISR_TXE && USART3->CR1 & USART_CR1_TXEIE) {
        uint8_t byte;
        if (ring_get(&to_send, &byte))
            USART3->TDR = byte;
        else
            USART3->CR1 &= ~USART_CR1_TXEIE;
    }
}

void link_start(void)
{
    RCC->AHB1ENR |= RCC_AHB1_GPIO('D');
    RCC->APB1ENR |= RCC_APB1_USART3;
    pin_pull_up(GPIO('D'), RX); // a line that is not connected is silent
    pin_alternate(GPIO('D'), TX, AF_USART3);
    pin_alternate(GPIO('D'), RX, AF_USART3);
    USART3->BRR = (PCLK1_HZ + BAUD / 2) / BAUD;
    USART3->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE | USART_CR1_RXNEIE;
    irq_enable_line(USART3_IRQ, LEVEL);
}

uint32_t link_waiting(void) { return ring_fill(&received); }

bool link_get(uint8_t *byte) { return ring_get(&received, byte); }

void link_send(const uint8_t *data, uint32_t count)
{
    if (RING_BYTES - ring_fill(&to_send) < count)
        return;
    for (uint32_t i = 0; i < count; ++i)
        ring_put(&to_send, data[i]);
    USART3->CR1 |= USART_CR1_TXEIE;
}
