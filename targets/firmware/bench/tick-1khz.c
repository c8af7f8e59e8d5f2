// SPDX-License-Identifier: GPL-2.0-or-later
//
// What most firmware does most of the time: nothing, a thousand times a second. PA0 toggles each millisecond at 72 MHz.

#include "chip/stm32f103.h"
#include "clock.h"
#include "handlers.h"
#include "pin.h"

void SysTick_Handler(void) { pin_toggle(GPIOA, 0); }

int main(void)
{
    clock_72mhz();
    RCC->APB2ENR |= RCC_APB2_GPIOA;
    pin_mode(GPIOA, 0, PIN_OUTPUT);
    SYSTICK->LOAD = clock_hclk_hz() / 1000 - 1;
    SYSTICK->VAL = 0;
    SYSTICK->CTRL = SYSTICK_CLKSOURCE | SYSTICK_TICKINT | SYSTICK_ENABLE;
    for (;;)
        WFI();
}
