// SPDX-License-Identifier: GPL-2.0-or-later
//
// Pins, the core's interrupts and tick, the serial line.

#include "opencm3.h"

void gpio_set_mode(volatile gpio_t *port, uint32_t mode, uint32_t cnf, uint32_t pins)
{
    for (uint32_t pin = 0; pin < 16; ++pin) {
        if (!(pins & 1u << pin))
            continue;
        uint32_t shift = pin % 8 * 4;
        uint32_t word = port->CR[pin / 8];
        word &= ~(0xFu << shift);
        word |= mode << shift | cnf << (shift + 2);
        port->CR[pin / 8] = word;
    }
}

void gpio_set(volatile gpio_t *port, uint32_t pins) { port->BSRR = pins; }

void gpio_clear(volatile gpio_t *port, uint32_t pins) { port->BSRR = pins << 16; }

void nvic_enable_irq(enum irq irq) { NVIC->ISER[irq / 32] = IRQ_BIT(irq); }

void systick_set_clocksource(uint32_t source) { SYSTICK->CTRL = (SYSTICK->CTRL & ~SYSTICK_CLKSOURCE) | source; }

void systick_set_reload(uint32_t value) { SYSTICK->LOAD = value; }

void systick_interrupt_enable(void) { SYSTICK->CTRL |= SYSTICK_TICKINT; }

void systick_counter_enable(void) { SYSTICK->CTRL |= SYSTICK_ENABLE; }

void usart_set_baudrate(volatile usart_t *usart, uint32_t baud)
{
    uint32_t clock = usart == USART1 ? rcc_apb2_frequency : rcc_apb1_frequency;
    usart->BRR = (clock + baud / 2) / baud;
}

void usart_set_databits(volatile usart_t *usart, uint32_t bits)
{
    if (bits == 8)
        usart->CR1 &= ~USART_CR1_M;
    else
        usart->CR1 |= USART_CR1_M;
}

void usart_set_stopbits(volatile usart_t *usart, uint32_t stopbits)
{
    usart->CR2 = (usart->CR2 & ~(3u << USART_CR2_STOP_SHIFT)) | stopbits;
}

void usart_set_mode(volatile usart_t *usart, uint32_t mode)
{
    usart->CR1 = (usart->CR1 & ~(USART_CR1_TE | USART_CR1_RE)) | mode;
}

void usart_set_parity(volatile usart_t *usart, uint32_t parity)
{
    usart->CR1 = (usart->CR1 & ~(USART_CR1_PCE | USART_CR1_PS)) | parity;
}

void usart_set_flow_control(volatile usart_t *usart, uint32_t flow_control)
{
    usart->CR3 = (usart->CR3 & ~(USART_CR3_RTSE | USART_CR3_CTSE)) | flow_control;
}

void usart_enable(volatile usart_t *usart) { usart->CR1 |= USART_CR1_UE; }

void usart_send_blocking(volatile usart_t *usart, uint16_t data)
{
    while (!(usart->SR & USART_SR_TXE)) {
    }
    usart->DR = data & 0x1FF;
}
