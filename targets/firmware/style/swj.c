// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: a vendor's board support, which takes no setting for granted. It writes SWJ_CFG, so that PB3 and PB4 are
// free and only SWD is left, and polls until it reads back what it wrote; RM0008 calls the bits write-only (9.4.2). Then PB3
// toggles each millisecond, and USART1 (PB6 after a remap that reads MAPR, changes it and writes it; 115200 8N1) says so.

#include "chip/stm32f103.h"
#include "clock.h"
#include "pin.h"

#define BAUD 115200u
#define SWJ_CFG (7u << AFIO_MAPR_SWJ_SHIFT)

static void set_and_confirm(volatile uint32_t *reg, uint32_t mask, uint32_t value)
{
    *reg = (*reg & ~mask) | value;
    while ((*reg & mask) != value) {
    }
}

static void print(const char *text)
{
    for (; *text; ++text) {
        while (!(USART1->SR & USART_SR_TXE)) {
        }
        USART1->DR = (uint8_t)*text;
    }
}

static void start_tick(void)
{
    SYSTICK->LOAD = clock_hclk_hz() / 1000 - 1;
    SYSTICK->VAL = 0;
    SYSTICK->CTRL = SYSTICK_CLKSOURCE | SYSTICK_ENABLE;
}

int main(void)
{
    clock_72mhz();
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOB | RCC_APB2_USART1;
    set_and_confirm(&AFIO->MAPR, SWJ_CFG, AFIO_MAPR_SWD_ONLY);
    set_and_confirm(&AFIO->MAPR, AFIO_MAPR_USART1, AFIO_MAPR_USART1);
    pin_mode(GPIOB, 3, PIN_OUTPUT);
    pin_mode(GPIOB, 6, PIN_ALTERNATE);
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE;
    print("only SWD is left\r\n");
    start_tick();
    for (;;) {
        while (!(SYSTICK->CTRL & SYSTICK_COUNTFLAG)) {
        }
        pin_toggle(GPIOB, 3);
    }
}
