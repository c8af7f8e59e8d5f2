// SPDX-License-Identifier: GPL-2.0-or-later
//
// SysTick (DDI 0403, B3.3; PM0056, 4.5; RM0008, 10.1.2), measured with DWT_CYCCNT.

#include "check.h"
#include "chip/stm32f103.h"
#include "cycles.h"
#include "handlers.h"
#include "wait.h"

#define RUN (SYSTICK_CLKSOURCE | SYSTICK_ENABLE)
#define POLL 40 // cycles that a polling loop may be late

static volatile uint32_t ticks;
static volatile uint32_t last_tick, first_tick;

void SysTick_Handler(void)
{
    last_tick = cycles();
    if (ticks++ == 0)
        first_tick = last_tick;
}

static void start(uint32_t load, uint32_t control)
{
    SYSTICK->CTRL = 0;
    SYSTICK->LOAD = load;
    SYSTICK->VAL = 0;
    SYSTICK->CTRL = control;
}

static uint32_t cycles_of_periods(uint32_t periods)
{
    while (!(SYSTICK->CTRL & SYSTICK_COUNTFLAG)) {
    }
    uint32_t begin = cycles();
    while (periods--)
        while (!(SYSTICK->CTRL & SYSTICK_COUNTFLAG)) {
        }
    return cycles() - begin;
}

static void registers(void)
{
    check_equal("ctrl-reset", SYSTICK->CTRL & 7, 0);
    check_equal("calib-is-1-ms-at-9-mhz", SYSTICK->CALIB & 0xFFFFFF, 9000);
    SYSTICK->LOAD = 0xFFFFFFFF;
    check_equal("load-has-24-bits", SYSTICK->LOAD, 0xFFFFFF);
    SYSTICK->VAL = 0x123456;
    check_equal("writing-val-clears-it", SYSTICK->VAL, 0);
}

static void counting(void)
{
    start(0xFFFFFF, RUN);
    uint32_t a = SYSTICK->VAL;
    uint32_t b = SYSTICK->VAL;
    check("counts-down", a > b && a - b < 20);
    uint32_t start_cycles = cycles();
    uint32_t start_value = SYSTICK->VAL;
    wait_cycles(5000);
    uint32_t by_value = start_value - SYSTICK->VAL;
    check_range("counts-hclk", by_value - (cycles() - start_cycles) + 20, 0, 40);
    SYSTICK->CTRL = 0;
    a = SYSTICK->VAL;
    wait_cycles(100);
    check_equal("stands-still-when-disabled", SYSTICK->VAL, a);

    start(1999, RUN);
    check_range("period-is-load-plus-1", cycles_of_periods(16), 16 * 2000 - POLL, 16 * 2000 + POLL);
    start(249, SYSTICK_ENABLE);
    check_range("hclk-divided-by-8", cycles_of_periods(16), 16 * 2000 - POLL, 16 * 2000 + POLL);
}

static void count_flag(void)
{
    start(5000, RUN);
    bool flagged = wait_until(SYSTICK->CTRL & SYSTICK_COUNTFLAG);
    bool cleared = !(SYSTICK->CTRL & SYSTICK_COUNTFLAG);
    check("countflag", flagged);
    check("countflag-clears-on-read", cleared);
    wait_cycles(6000);
    SYSTICK->VAL = 1;
    cleared = !(SYSTICK->CTRL & SYSTICK_COUNTFLAG);
    check("countflag-clears-on-val-write", cleared);
    check("no-interrupt-without-tickint", !(SCB->ICSR & ICSR_PENDSTSET) && ticks == 0);
    start(5000, RUN);
    wait_cycles(100);
    SYSTICK->LOAD = 1000; // is taken at the next reload
    check_range("load-waits-for-reload", SYSTICK->VAL, 1001, 5000);
    wait_until(SYSTICK->CTRL & SYSTICK_COUNTFLAG);
    check_range("new-load-after-reload", SYSTICK->VAL, 0, 1000);
}

static void interrupts(void)
{
    start(2999, RUN | SYSTICK_TICKINT);
    while (ticks < 11) {
    }
    SYSTICK->CTRL = 0;
    check_range("ten-interrupt-periods", last_tick - first_tick, 10 * 3000 - POLL, 10 * 3000 + POLL);

    ticks = 0;
    irq_disable();
    start(999, RUN | SYSTICK_TICKINT);
    wait_cycles(3500);
    SYSTICK->CTRL = 0;
    check("masked-tick-pends", SCB->ICSR & ICSR_PENDSTSET);
    irq_enable();
    ISB();
    check_equal("three-masked-ticks-are-one", ticks, 1);

    ticks = 0;
    irq_disable();
    start(999, RUN | SYSTICK_TICKINT);
    wait_cycles(1500);
    SYSTICK->CTRL = 0;
    SCB->ICSR = ICSR_PENDSTCLR;
    irq_enable();
    ISB();
    check_equal("pendstclr-drops-tick", ticks, 0);
}

static void one_shot(void)
{
    // LOAD = 0 stops the counter when it gets to 0 (B3.3.1)
    ticks = 0;
    start(2000, RUN | SYSTICK_TICKINT);
    wait_cycles(100);
    SYSTICK->LOAD = 0;
    wait_cycles(8000);
    check_equal("load-0-stops-after-one", ticks, 1);
    check_equal("load-0-stays-at-0", SYSTICK->VAL, 0);
    SYSTICK->CTRL = 0;
}

int main(void)
{
    cycles_start();
    registers();
    counting();
    count_flag();
    interrupts();
    one_shot();
    check_done();
}
