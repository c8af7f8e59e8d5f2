// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: a motion controller on a Nucleo-H753ZI. Its clock is CYCCNT, of which it never unlocks the DWT; its software
// timers come by SysTick, which is given one shot at a time: LOAD, then VAL, then LOAD = 0, so that it stops at zero. LD1
// (PB0) toggles each millisecond, LD2 (PE1) each 0.3 ms; the watchdog bites after 10 ms without the former.

#include <stdbool.h>
#include <stdint.h>

#include "chip/cpu.h"
#include "cycles.h"
#include "h753/clock.h"
#include "h753/handlers.h"
#include "h753/registers.h"

#define SHORTEST 200u // cycles; what is nearer is waited for
#define US (CPU_HZ / 1000000u)
#define IWDG_KR (*(volatile uint32_t *)0x58004800u)
#define IWDG_RLR (*(volatile uint32_t *)0x58004808u)
#define IWDG_SR (*(volatile uint32_t *)0x5800480Cu)

struct timer {
    uint32_t at, period;
    void (*act)(void);
};

static void fast(void)
{
    static bool on;
    pin_write('E', 1, on = !on);
}

static void slow(void)
{
    static bool on;
    pin_write('B', 0, on = !on);
    IWDG_KR = 0xAAAA;
}

static struct timer timers[] = {{.period = 300 * US, .act = fast}, {.period = 1000 * US, .act = slow}};

static struct timer *next_timer(void) { return (int32_t)(timers[0].at - timers[1].at) <= 0 ? &timers[0] : &timers[1]; }

void SysTick_Handler(void)
{
    for (;;) {
        struct timer *timer = next_timer();
        int32_t ahead = (int32_t)(timer->at - cycles());
        if (ahead > (int32_t)SHORTEST) {
            SYSTICK->LOAD = (uint32_t)ahead;
            SYSTICK->VAL = 0;
            SYSTICK->LOAD = 0;
            return;
        }
        while ((int32_t)(timer->at - cycles()) > 0) {
        }
        timer->act();
        timer->at += timer->period;
    }
}

int main(void)
{
    clock_start();
    RCC->AHB4ENR |= RCC_AHB4_GPIO('B') | RCC_AHB4_GPIO('E');
    pin_mode('B', 0, PIN_OUTPUT);
    pin_mode('E', 1, PIN_OUTPUT);
    cycles_start();
    DWT->CYCCNT = 0;
    for (unsigned i = 0; i < sizeof timers / sizeof *timers; ++i)
        timers[i].at = timers[i].period;
    IWDG_KR = 0xCCCC;
    IWDG_KR = 0x5555;
    IWDG_RLR = 80; // of LSI / 4
    while (IWDG_SR) {
    }
    IWDG_KR = 0xAAAA;
    SYSTICK->CTRL = SYSTICK_CLKSOURCE | SYSTICK_TICKINT | SYSTICK_ENABLE;
    SCB->ICSR = ICSR_PENDSTSET;
    for (;;)
        WFI();
}
