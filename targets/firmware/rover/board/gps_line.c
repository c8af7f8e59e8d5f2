// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/board/gps_line.h"

#include "ring.h"
#include "rover/board/clock.h"
#include "rover/chip/gpio.h"
#include "rover/chip/irq.h"
#include "rover/chip/rcc.h"
#include "rover/chip/usart.h"

#define TX 5
#define RX 6
#define AF_USART2 7
#define GPS_BAUD 9600u
#define LEVEL 1

static struct ring received;

void USART2_IRQHandler(void)
{
    uint32_t flags = USART2->ISR;
    if (flags & USART_ISR_ORE)
        USART2->ICR = USART_ICR_ORECF;
    if (flags & USART_ISR_RXNE)
        ring_put(&received, (uint8_t)USART2->RDR);
}

void gps_line_start(void)
{
    RCC->AHB1ENR |= RCC_AHB1_GPIO('D');
    RCC->APB1ENR |= RCC_APB1_USART2;
    pin_pull_up(GPIO('D'), RX);
    pin_alternate(GPIO('D'), TX, AF_USART2);
    pin_alternate(GPIO('D'), RX, AF_USART2);
    USART2->BRR = (PCLK1_HZ + GPS_BAUD / 2) / GPS_BAUD;
    USART2->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE | USART_CR1_RXNEIE;
    irq_enable_line(USART2_IRQ, LEVEL);
}

bool gps_line_get(uint8_t *byte) { return ring_get(&received, byte); }
