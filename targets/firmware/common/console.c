// SPDX-License-Identifier: GPL-2.0-or-later

#include "console.h"

#if SEMIHOSTING

#include "semihosting.h"

void console_write(const char *text) { semihosting_write(text); }

void console_exit(uint32_t status)
{
    semihosting_exit(status);
    for (;;) {
    }
}

#else

#include "chip/stm32f103.h"
#include "clock.h"
#include "pin.h"

#define BAUD 115200u
#define TX 9
#define LED 13

static void send(const char *text)
{
    USART1->CR1 = 0;
    USART1->CR2 = 0;
    USART1->CR3 = 0;
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE;
    for (; *text; ++text) {
        while (!(USART1->SR & USART_SR_TXE)) {
        }
        USART1->DR = (uint8_t)*text;
    }
    while (!(USART1->SR & USART_SR_TC)) {
    }
}

void console_write(const char *text)
{
    uint32_t gates = RCC->APB2ENR;
    RCC->APB2ENR = gates | RCC_APB2_GPIOA | RCC_APB2_USART1;
    uint32_t pins = GPIOA->CR[TX / 8];
    usart_t kept = *USART1;
    pin_mode(GPIOA, TX, PIN_ALTERNATE);
    send(text);
    USART1->CR1 = kept.CR1;
    USART1->CR2 = kept.CR2;
    USART1->CR3 = kept.CR3;
    USART1->BRR = kept.BRR;
    GPIOA->CR[TX / 8] = pins;
    RCC->APB2ENR = gates;
}

void console_exit(uint32_t status)
{
    RCC->APB2ENR |= RCC_APB2_GPIOC;
    pin_write(GPIOC, LED, false);
    pin_mode(GPIOC, LED, PIN_OUTPUT);
    for (;;) {
        if (status)
            pin_toggle(GPIOC, LED);
        for (uint32_t loops = clock_hclk_hz() / 16; loops; --loops)
            NOP();
    }
}

#endif
