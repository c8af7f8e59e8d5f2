// SPDX-License-Identifier: GPL-2.0-or-later
//
// The independent watchdog is started and never fed: it resets the chip each 25 ms or so, for ever.

#include "bad.h"
#include "chip/stm32f103.h"

__attribute__((noinline)) static void forget_to_feed(void)
{
    for (;;) {
    }
}

int main(void)
{
    IWDG->KR = IWDG_KEY_START;
    IWDG->KR = IWDG_KEY_UNLOCK;
    IWDG->RLR = 250; // of 0.1 ms each; the counter gets it with the next reload
    while (IWDG->SR) {
    }
    IWDG->KR = IWDG_KEY_RELOAD;
    alive("iwdg-loop\r\n");
    forget_to_feed();
    return 0;
}
