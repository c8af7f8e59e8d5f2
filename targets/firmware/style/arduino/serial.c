// SPDX-License-Identifier: GPL-2.0-or-later
//
// USART1, whose interrupt empties a ring. Who prints waits only while the ring is full.

#include "arduino.h"
#include "chip/stm32f103.h"
#include "clock.h"
#include "handlers.h"

#define RING 64u

static volatile uint8_t ring[RING];
static volatile uint32_t head, tail;

void USART1_IRQHandler(void)
{
    if (!(USART1->SR & USART_SR_TXE))
        return;
    if (head == tail)
        *bit_of(&USART1->CR1, 7) = 0; // TXEIE
    else
        USART1->DR = ring[tail++ % RING];
}

void Serial_begin(uint32_t baud)
{
    pinMode(PA9, ALTERNATE);
    RCC->APB2ENR |= RCC_APB2_USART1;
    USART1->BRR = (clock_pclk2_hz() + baud / 2) / baud;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE;
    irq_line_enable(USART1_IRQ);
}

void Serial_print(const char *text)
{
    for (; *text; ++text) {
        while (head - tail == RING) {
        }
        ring[head % RING] = (uint8_t)*text;
        ++head;
        *bit_of(&USART1->CR1, 7) = 1;
    }
}

void Serial_println(const char *text)
{
    Serial_print(text);
    Serial_print("\r\n");
}
