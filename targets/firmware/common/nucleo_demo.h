// SPDX-License-Identifier: GPL-2.0-or-later
//
// A Nucleo-144 shows that it lives: LD1 blinks by SysTick, USART3 (the ST-LINK's virtual COM port, 115200 8N1) says what
// the floating-point unit has worked out and echoes what comes in. B1 switches LD2.
//
// The program of one board: included once, by a file that has the registers and clocks of its chip, and says where LD2 is
// (LD2_PORT, LD2), how fast the core runs (CORE_HZ), what to say first (GREETING), and how to open the gates of ports B to
// D and of LD2 (open_port_gates) and of USART3 (open_usart_gate).

#pragma once

#include <stdint.h>

#include "chip/cpu.h"
#include "f767/number.h"

#define BAUD 115200u
#define TICKS_PER_S 1000u
#define BLINK_MS 250u

enum { LD1 = 0, B1 = 13, TX = 8, RX = 9, AF_USART3 = 7 };

static volatile uint32_t ticks;

void SysTick_Handler(void)
{
    if (++ticks % BLINK_MS == 0)
        pin_write('B', LD1, !pin_read('B', LD1));
    pin_write(LD2_PORT, LD2, pin_read('C', B1));
}

void USART3_IRQHandler(void)
{
    if (USART3->ISR & USART_ISR_ORE)
        USART3->ICR = USART_ICR_ORECF;
    if (USART3->ISR & USART_ISR_RXNE)
        USART3->TDR = USART3->RDR;
}

static void start_pins(void)
{
    open_port_gates();
    pin_mode('B', LD1, PIN_OUTPUT);
    pin_mode(LD2_PORT, LD2, PIN_OUTPUT);
    pin_mode('C', B1, PIN_INPUT);
    pin_alternate('D', TX, AF_USART3);
    pin_alternate('D', RX, AF_USART3);
}

static void start_usart(void)
{
    open_usart_gate();
    USART3->BRR = (PCLK1_HZ + BAUD / 2) / BAUD;
    USART3->CR1 = USART_CR1_UE | USART_CR1_RE | USART_CR1_TE;
}

static void say(const char *text)
{
    for (; *text; ++text) {
        while (!(USART3->ISR & USART_ISR_TXE)) {
        }
        USART3->TDR = (uint8_t)*text;
    }
}

static void say_number(const char *what, double value)
{
    char text[NUMBER_BYTES];
    number_write(text, value);
    say(what);
    say(text);
    say("\r\n");
}

// Double precision, many divisions: the arithmetic-geometric mean of Gauss and Legendre.
static double pi(void)
{
    double a = 1, b = __builtin_sqrt(0.5), t = 0.25, p = 1;
    for (int round = 0; round < 4; ++round) {
        double mean = (a + b) / 2, step = a - mean;
        b = __builtin_sqrt(a * b);
        t -= p * step * step;
        a = mean;
        p *= 2;
    }
    return (a + b) * (a + b) / (4 * t);
}

// Single precision, fused: the sum of a series that converges slowly.
static float harmonic(int terms)
{
    float sum = 0;
    for (int n = 1; n <= terms; ++n)
        sum = __builtin_fmaf(1.0f / (float)n, 1.0f, sum);
    return sum;
}

int main(void)
{
    clock_start();
    start_pins();
    start_usart();
    SYSTICK->LOAD = CORE_HZ / TICKS_PER_S - 1;
    SYSTICK->VAL = 0;
    SYSTICK->CTRL = SYSTICK_ENABLE | SYSTICK_TICKINT | SYSTICK_CLKSOURCE;
    say(GREETING);
    say_number("pi    ", pi());
    say_number("H100  ", (double)harmonic(100));
    say_number("1/3   ", 1.0 / 3);
    USART3->CR1 |= USART_CR1_RXNEIE;
    interrupt_enable(USART3_IRQ, 4);
    for (;;)
        WFI();
}
