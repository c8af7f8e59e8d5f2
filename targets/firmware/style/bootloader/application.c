// SPDX-License-Identifier: GPL-2.0-or-later
//
// An application linked behind a boot loader, at 0x08002000. It takes no chances and sets VTOR itself. The LED toggles each
// 250 ms from SysTick, whose vector is found only if VTOR is right; USART1 (PA9, 115200 8N1) says once where we run.

#include "chip/stm32f103.h"
#include "clock.h"
#include "handlers.h"
#include "pin.h"
#include "text.h"

#define BAUD 115200u
#define LED 13

extern const uint32_t vector_table[];

void SysTick_Handler(void)
{
    static uint32_t ms;
    if (++ms % 250 == 0)
        pin_toggle(GPIOC, LED);
}

static void say_where(void)
{
    struct line line = EMPTY_LINE;
    line_text(&line, "application at ");
    line_hex(&line, (uint32_t)(uintptr_t)vector_table);
    line_text(&line, "\r\n");
    for (const char *at = line.text; *at; ++at) {
        while (!(USART1->SR & USART_SR_TXE)) {
        }
        USART1->DR = (uint8_t)*at;
    }
}

int main(void)
{
    SCB->VTOR = (uint32_t)(uintptr_t)vector_table;
    clock_72mhz();
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_GPIOC | RCC_APB2_USART1;
    pin_mode(GPIOC, LED, PIN_OUTPUT);
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE;
    SYSTICK->LOAD = clock_hclk_hz() / 1000 - 1;
    SYSTICK->VAL = 0;
    SYSTICK->CTRL = SYSTICK_CLKSOURCE | SYSTICK_TICKINT | SYSTICK_ENABLE;
    say_where();
    for (;;)
        WFI();
}
