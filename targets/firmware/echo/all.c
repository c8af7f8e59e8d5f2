// SPDX-License-Identifier: GPL-2.0-or-later
//
// All three serial ports send back what they receive, 115200 8N1: USART1 PA9, PA10; USART2 PA2, PA3; USART3 PB10, PB11.

#include "chip/stm32f103.h"
#include "clock.h"
#include "handlers.h"
#include "pin.h"
#include "ring.h"

#define BAUD 115200u

static struct ring rings[3];

static void serve(volatile usart_t *usart, struct ring *ring)
{
    uint32_t status = usart->SR;
    if (status & (USART_SR_RXNE | USART_SR_ORE)) {
        ring_put(ring, (uint8_t)usart->DR);
        usart->CR1 |= USART_CR1_TXEIE;
    }
    if (status & USART_SR_TXE) {
        uint8_t byte;
        if (ring_get(ring, &byte))
            usart->DR = byte;
        else
            usart->CR1 &= ~USART_CR1_TXEIE;
    }
}

void USART1_IRQHandler(void) { serve(USART1, &rings[0]); }
void USART2_IRQHandler(void) { serve(USART2, &rings[1]); }
void USART3_IRQHandler(void) { serve(USART3, &rings[2]); }

static void open(volatile usart_t *usart, port_t port, unsigned tx, uint32_t pclk_hz, enum irq irq)
{
    pin_mode(port, tx, PIN_ALTERNATE);
    pin_pull(port, tx + 1, true);
    usart->BRR = (pclk_hz + BAUD / 2) / BAUD;
    usart->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE | USART_CR1_RXNEIE;
    irq_line_enable(irq);
}

int main(void)
{
    clock_72mhz();
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_GPIOB | RCC_APB2_USART1;
    RCC->APB1ENR |= RCC_APB1_USART2 | RCC_APB1_USART3;
    open(USART1, GPIOA, 9, clock_pclk2_hz(), USART1_IRQ);
    open(USART2, GPIOA, 2, clock_pclk1_hz(), USART2_IRQ);
    open(USART3, GPIOB, 10, clock_pclk1_hz(), USART3_IRQ);
    for (;;)
        WFI();
}
