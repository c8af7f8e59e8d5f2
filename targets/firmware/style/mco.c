// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: a program that shows its clocks at MCO (PA8), to be measured there: each for 5 ms, HSI (8 MHz), HSE
// (8 MHz), half of the PLL (36 MHz), SYSCLK on the HSE (8 MHz), and none (RM0008, 7.2.10). PC13 toggles with each.

#include "chip/stm32f103.h"
#include "clock.h"
#include "cycles.h"
#include "pin.h"

#define MCO 8
#define LED 13

static void show(uint32_t clock)
{
    RCC->CFGR = (RCC->CFGR & ~(7u << 24)) | clock << 24;
    pin_toggle(GPIOC, LED);
    wait_cycles(clock_hclk_hz() / 200);
}

int main(void)
{
    clock_72mhz();
    cycles_start();
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_GPIOC;
    pin_mode(GPIOC, LED, PIN_OUTPUT);
    pin_mode(GPIOA, MCO, PIN_ALTERNATE);
    for (;;) {
        show(5);
        show(6);
        show(7);
        RCC->CFGR = (RCC->CFGR & ~3u) | SYSCLK_HSE;
        show(4);
        show(0);
        RCC->CFGR = (RCC->CFGR & ~3u) | SYSCLK_PLL; // too fast for the pin
    }
}
