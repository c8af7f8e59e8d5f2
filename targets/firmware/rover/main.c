// SPDX-License-Identifier: GPL-2.0-or-later
//
// The rover of nhorro/ceai2020 as its document and manual promise it, or, built with the options of options.h and defects.h,
// as it was published. One thread, woken by interrupts; between them it sleeps.

#include "chip/cpu.h"
#include "rover/board/clock.h"
#include "rover/board/leds.h"
#include "rover/board/link.h"
#include "rover/board/motors.h"
#include "rover/board/time.h"
#include "rover/board/watchdog.h"
#include "rover/board/wheels.h"
#include "rover/options.h"
#include "rover/rover.h"

#define SLOW_START_TICKS 96u // G2's sleeps add up to 955 ms

static uint32_t first_tick; // of the clock; the rover's is 0

// Interrupts are held back between the look at the clock and the sleep: one that comes then ends the sleep at once
// (DDI 0403, B1.5.17). `next` is the tick that is awaited; any interrupt ends the wait.
static void sleep_before(uint32_t next)
{
    irq_disable();
    if (time_ticks() - first_tick < next && (DEFECT_POLLED || link_waiting() == 0))
        WFI();
    irq_enable();
}

static void start(void)
{
    clock_start();
    leds_start();
    motors_start();
    time_start();
    wheels_start();
    link_start();
    rover_start();
    watchdog_start();
    if (DEFECT_SLOW_START)
        while (time_ticks() < SLOW_START_TICKS) {
            watchdog_feed();
            WFI();
        }
    first_tick = time_ticks();
}

int main(void)
{
    start();
    for (uint32_t next = 0;;) {
        rover_poll(time_us());
        for (; (int32_t)(time_ticks() - first_tick - next) >= 0; ++next) {
            watchdog_feed();
            rover_tick(next, time_us());
        }
        sleep_before(next);
    }
}
