// SPDX-License-Identifier: GPL-2.0-or-later

#include "bad.h"

#include "chip/stm32f103.h"
#include "pin.h"

void alive(const char *line)
{
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_GPIOC | RCC_APB2_USART1;
    pin_mode(GPIOC, 13, PIN_OUTPUT); // low, lit
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    USART1->BRR = (8000000u + 57600u) / 115200u;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE;
    for (; *line; ++line) {
        while (!(USART1->SR & USART_SR_TXE)) {
        }
        USART1->DR = (uint8_t)*line;
    }
    while (!(USART1->SR & USART_SR_TC)) {
    }
}
