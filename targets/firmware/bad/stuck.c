// SPDX-License-Identifier: GPL-2.0-or-later
//
// A wait for a flag that never comes: the update of a timer whose counter was never enabled.

#include "bad.h"

#include "chip/stm32f103.h"

__attribute__((noinline)) static void wait_for_update(void)
{
    while (!(TIM2->SR & TIM_UIF)) {
    }
}

int main(void)
{
    alive("stuck\r\n");
    RCC->APB1ENR |= RCC_APB1_TIM2;
    TIM2->ARR = 999;
    wait_for_update();
    return 0;
}
