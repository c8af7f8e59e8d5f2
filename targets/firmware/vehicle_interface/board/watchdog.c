// SPDX-License-Identifier: GPL-2.0-or-later

#include "vehicle_interface/board/watchdog.h"

#include "vehicle_interface/chip/iwdg.h"
#include "vehicle_interface/kernel/kernel.h"
#include "vehicle_interface/options.h"

#define STEPS 500u // of 1 ms: 32 kHz / 32

static uint32_t alive;

void watchdog_start(void)
{
    if (DEFECT_NO_WATCHDOG)
        return;
    IWDG1->KR = IWDG_START;
    IWDG1->KR = IWDG_UNLOCK;
    IWDG1->PR = IWDG_DIV32;
    IWDG1->RLR = STEPS - 1;
    while (IWDG1->SR) { // all have to reach the clock of the watchdog (RM0433, section 45.4.4)
    }
    IWDG1->KR = IWDG_FEED;
}

void watchdog_alive(enum who who)
{
    kernel_lock();
    alive |= who;
    if (alive == ALIVE_ALL) {
        alive = 0;
        if (!DEFECT_NO_WATCHDOG)
            IWDG1->KR = IWDG_FEED;
    }
    kernel_unlock();
}
