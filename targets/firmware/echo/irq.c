// SPDX-License-Identifier: GPL-2.0-or-later
//
// USART1 (PA9, PA10) sends back what it receives, by interrupts and a ring. BAUD is 115200 unless built otherwise. PC13
// toggles with each byte.

#include "chip/stm32f103.h"
#include "clock.h"
#include "handlers.h"
#include "pin.h"
#include "ring.h"

#ifndef BAUD
#define BAUD 115200u
#endif
#define LED 13

static struct ring ring;

void USART1_IRQHandler(void)
{
    uint32_t status = USART1->SR;
    if (status & (USART_SR_RXNE | USART_SR_ORE)) {
        ring_put(&ring, (uint8_t)USART1->DR);
        USART1->CR1 |= USART_CR1_TXEIE;
        pin_toggle(GPIOC, LED);
    }
    if (status & USART_SR_TXE) {
        uint8_t byte;
        if (ring_get(&ring, &byte))
            USART1->DR = byte;
        else
            USART1->CR1 &= ~USART_CR1_TXEIE;
    }
}

int main(void)
{
    clock_72mhz();
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_GPIOC | RCC_APB2_USART1;
    pin_mode(GPIOC, LED, PIN_OUTPUT);
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    pin_pull(GPIOA, 10, true);
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE | USART_CR1_RXNEIE;
    irq_line_enable(USART1_IRQ);
    for (;;)
        WFI();
}
