// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/board/watchdog.h"

#include "rover/chip/iwdg.h"

#define STEPS 500u // of 1 ms: 32 kHz / 32

void watchdog_start(void)
{
    IWDG->KR = IWDG_START;
    IWDG->KR = IWDG_UNLOCK;
    IWDG->PR = IWDG_DIV32;
    IWDG->RLR = STEPS - 1;
    while (IWDG->SR) { // both have to reach the clock of the watchdog (RM0410, 30.4.4)
    }
    IWDG->KR = IWDG_FEED;
}

void watchdog_feed(void) { IWDG->KR = IWDG_FEED; }
