// SPDX-License-Identifier: GPL-2.0-or-later
//
// The part of the self-tests of the low-power timer that STM32F7 and STM32H7 have in common. LPTIM1 runs on PCLK1, which is
// HCLK, so cycles of the core are ticks of it. Where the manual names no delay, the tolerance spans what was measured.

#include "lptim.h"

#include "check.h"
#include "cycles.h"

#define SETTLED 200 // cycles in which a pull moves a pin, and a filterless input is taken

static uint32_t take_flags(void)
{
    uint32_t flags = LPTIM1->ISR;
    LPTIM1->ICR = flags;
    return flags;
}

static uint32_t cycles_until(uint32_t flag)
{
    uint32_t start = cycles();
    while (!(LPTIM1->ISR & flag) && cycles() - start < 100000) {
    }
    return cycles() - start;
}

void lptim_open(volatile lptim_t *timer, uint32_t settings, uint32_t interrupts, uint32_t reload, uint32_t compare)
{
    timer->CFGR = settings;
    timer->IER = interrupts;
    timer->CR = LPTIM_ENABLE;
    timer->ARR = reload;
    timer->CMP = compare;
    if (settings & LPTIM_CKSEL)
        return; // whose clock comes later
    uint32_t start = cycles();
    while ((timer->ISR & (LPTIM_ARROK | LPTIM_CMPOK)) != (LPTIM_ARROK | LPTIM_CMPOK) && cycles() - start < 100000) {
    }
    timer->ICR = LPTIM_ALL;
}

static void open_anew(uint32_t settings, uint32_t interrupts, uint32_t reload, uint32_t compare, uint32_t start)
{
    lptim_reset();
    lptim_open(LPTIM1, settings, interrupts, reload, compare);
    LPTIM1->CR = LPTIM_ENABLE | start;
}

static void after_reset(void)
{
    lptim_reset();
    check_equal("ISR-reset", LPTIM1->ISR, 0);
    check_equal("CFGR-reset", LPTIM1->CFGR, 0);
    check_equal("CMP-reset", LPTIM1->CMP, 0);
    check_equal("ARR-reset", LPTIM1->ARR, 1);
    check_equal("CNT-reset", LPTIM1->CNT, 0);
    LPTIM1->CR = LPTIM_CNTSTRT;
    check_equal("no-start-while-disabled", LPTIM1->CR, 0);
}

// With a prescaler the counter clock is slow enough to watch a write arrive.
static void synchronization(void)
{
    const uint32_t clock = 128;
    lptim_reset();
    LPTIM1->CFGR = LPTIM_CFGR_PRESC(7);
    LPTIM1->CR = LPTIM_ENABLE;
    LPTIM1->ARR = 0xFFFF;
    uint32_t at_once = LPTIM1->ISR, arr = cycles_until(LPTIM_ARROK);
    LPTIM1->ICR = LPTIM_ARROK;
    uint32_t cleared = LPTIM1->ISR & LPTIM_ARROK;
    LPTIM1->CMP = 0x1234;
    uint32_t cmp = cycles_until(LPTIM_CMPOK);
    check_equal("not-at-once", at_once, 0);
    check_range("ARROK-after-enabling", arr, 3 * clock, 6 * clock);
    check_equal("cleared-at-once", cleared, 0);
    check_range("CMPOK", cmp, clock, 4 * clock);
    check_equal("CMP-reads-back", LPTIM1->CMP, 0x1234);
}

static void prescaler(void)
{
    for (uint32_t shift = 0; shift < 8; shift += 7) {
        open_anew(LPTIM_CFGR_PRESC(shift), 0, 0xFFFF, 0xFFFF, LPTIM_CNTSTRT);
        wait_cycles(2000);
        uint32_t from = LPTIM1->CNT, start = cycles();
        wait_cycles(12800);
        uint32_t counted = LPTIM1->CNT - from, took = (cycles() - start) >> shift;
        check_range(shift ? "by-128" : "by-1", counted, took - (shift ? 2 : 40), took + (shift ? 2 : 40));
    }
}

static void continuous(void)
{
    open_anew(LPTIM_CFGR_PRESC(4), LPTIM_ARRM, 99, 49, LPTIM_CNTSTRT);
    cycles_until(LPTIM_ARRM);
    LPTIM1->ICR = LPTIM_ALL;
    lptim_forget();
    uint32_t half = cycles_until(LPTIM_CMPM), only = LPTIM1->ISR, asked = lptim_pending();
    uint32_t rest = cycles_until(LPTIM_ARRM), count = LPTIM1->CNT;
    check_range("half-a-period", half, 50 * 16 - 120, 50 * 16 + 60);
    check_equal("CMPM-alone", only, LPTIM_CMPM);
    check_equal("it-asks-for-no-other", asked, 0);
    check_range("the-other-half", rest, 50 * 16 - 120, 50 * 16 + 60);
    check_range("from-zero", count, 0, 4);
    check_equal("ARRM-asks", lptim_pending(), 1);
    LPTIM1->ICR = LPTIM_ALL;
    lptim_forget();
    check_equal("no-more", lptim_pending(), 0);
}

static void late_enable(void)
{
    open_anew(LPTIM_CFGR_PRESC(4), 0, 0xFFFF, 10, LPTIM_CNTSTRT);
    lptim_forget();
    cycles_until(LPTIM_CMPM);
    LPTIM1->IER = LPTIM_CMPM; // which the manual wants done before, but says what comes of it
    check_equal("enabled-too-late", lptim_pending(), 0);
}

static void comparing(void)
{
    open_anew(0, 0, 0xFFFF, 0xFFFF, LPTIM_CNTSTRT);
    wait_cycles(3000);
    LPTIM1->CMP = 100;
    cycles_until(LPTIM_CMPOK);
    wait_cycles(SETTLED);
    check_equal("behind-the-counter-matches", take_flags() & LPTIM_CMPM, LPTIM_CMPM);
    open_anew(LPTIM_CFGR_PRESC(4), 0, 99, 99, LPTIM_CNTSTRT);
    cycles_until(LPTIM_ARRM);
    check_equal("CMP-equal-to-ARR-matches", take_flags(), LPTIM_CMPM | LPTIM_ARRM);
}

static void single(void)
{
    open_anew(0, 0, 999, 499, LPTIM_SNGSTRT);
    wait_cycles(3000);
    check_equal("both-matches", take_flags(), LPTIM_CMPM | LPTIM_ARRM);
    check_equal("stopped-at-0", LPTIM1->CNT, 0);
    wait_cycles(3000);
    check_equal("once", take_flags(), 0);
    LPTIM1->CR = LPTIM_ENABLE | LPTIM_CNTSTRT;
    wait_cycles(5000);
    check_equal("now-for-ever", take_flags(), LPTIM_CMPM | LPTIM_ARRM);
    LPTIM1->CR = LPTIM_ENABLE | LPTIM_SNGSTRT;
    wait_cycles(3000);
    check_equal("and-stopped-again", LPTIM1->CNT, 0);
}

static void preload(void)
{
    static const char *const names[] = {"without-PRELOAD", "with-PRELOAD"};
    for (uint32_t on = 0; on < 2; ++on) {
        open_anew((on ? LPTIM_PRELOAD : 0u) | LPTIM_CFGR_PRESC(4), 0, 199, 0, LPTIM_CNTSTRT);
        cycles_until(LPTIM_ARRM);
        LPTIM1->ICR = LPTIM_ALL;
        LPTIM1->ARR = 99;
        uint32_t period = cycles_until(LPTIM_ARRM), want = on ? 200 : 100;
        check_range(names[on], period, want * 16 - 120, want * 16 + 60);
    }
}

static uint32_t high_of(uint32_t samples)
{
    uint32_t high = 0;
    for (uint32_t i = 0; i < samples; ++i)
        high += lptim_out();
    return high;
}

static void output(void)
{
    lptim_reset();
    check_equal("low", lptim_out(), 0);
    LPTIM1->CFGR = LPTIM_WAVPOL;
    wait_cycles(SETTLED);
    check_equal("WAVPOL-before-enabling", lptim_out(), 1);
    // 999 and 249: high for 750 of 1000
    open_anew(0, 0, 999, 249, LPTIM_CNTSTRT);
    uint32_t high = high_of(3000);
    check_range("three-quarters", high, 2150, 2350);
    open_anew(LPTIM_WAVPOL, 0, 999, 249, LPTIM_CNTSTRT);
    high = high_of(3000);
    check_range("one-quarter", high, 650, 850);
    open_anew(LPTIM_CFGR_PRESC(2), 0, 999, 499, LPTIM_SNGSTRT);
    uint32_t before = lptim_out();
    wait_cycles(2600);
    uint32_t within = lptim_out();
    wait_cycles(2600);
    check_equal("one-pulse-begins-low", before, 0);
    check_equal("is-high", within, 1);
    check_equal("and-ends", lptim_out(), 0);
    open_anew(LPTIM_WAVE | LPTIM_CFGR_PRESC(2), 0, 999, 499, LPTIM_SNGSTRT);
    wait_cycles(6000);
    check_equal("set-once-stays", lptim_out(), 1);
}

static void move(enum lptim_input input, bool high)
{
    lptim_pull(input, high);
    wait_cycles(SETTLED);
}

static void pulse(enum lptim_input input, uint32_t count)
{
    for (; count; --count) {
        move(input, true);
        move(input, false);
    }
}

static void triggers(void)
{
    lptim_pull(LPTIM_ETR, false);
    open_anew(LPTIM_TRIGEN_RISING, 0, 0xFFFF, 0xFFFF, LPTIM_CNTSTRT);
    wait_cycles(1000);
    check_equal("waits-for-its-trigger", LPTIM1->CNT, 0);
    move(LPTIM_ETR, true);
    check_range("and-starts", LPTIM1->CNT, 50, 0xFFFE);
    check_equal("EXTTRIG", take_flags(), LPTIM_EXTTRIG);
    uint32_t before = LPTIM1->CNT;
    pulse(LPTIM_ETR, 2);
    check("ignores-the-next", LPTIM1->CNT > before);
    check_equal("without-a-flag", take_flags(), 0);
    open_anew(LPTIM_TRIGEN_RISING | LPTIM_TIMOUT, 0, 0xFFFF, 8 * SETTLED, LPTIM_CNTSTRT);
    pulse(LPTIM_ETR, 10);
    check_equal("fed-in-time", take_flags(), LPTIM_EXTTRIG);
    wait_cycles(10 * SETTLED);
    check_equal("starved", take_flags(), LPTIM_CMPM);
}

static void inputs(void)
{
    lptim_pull(LPTIM_IN1, false);
    open_anew(LPTIM_CKSEL, 0, 0xFFFF, 0xFFFF, LPTIM_CNTSTRT);
    pulse(LPTIM_IN1, 20);
    check_equal("five-edges-are-lost", LPTIM1->CNT, 15);
    open_anew(LPTIM_COUNTMODE, 0, 0xFFFF, 0xFFFF, LPTIM_CNTSTRT);
    wait_cycles(SETTLED);
    pulse(LPTIM_IN1, 20);
    check_equal("none-where-they-are-sampled", LPTIM1->CNT, 20);
    open_anew(LPTIM_COUNTMODE | LPTIM_CKPOL_BOTH, 0, 0xFFFF, 0xFFFF, LPTIM_CNTSTRT);
    wait_cycles(SETTLED);
    pulse(LPTIM_IN1, 20);
    check_equal("both-edges", LPTIM1->CNT, 40);
}

// Four steps of an encoder: IN1 leads upwards.
static void turn(uint32_t rounds, bool up)
{
    enum lptim_input first = up ? LPTIM_IN1 : LPTIM_IN2, second = up ? LPTIM_IN2 : LPTIM_IN1;
    for (; rounds; --rounds) {
        move(first, true);
        move(second, true);
        move(first, false);
        move(second, false);
    }
}

static void encoder(void)
{
    lptim_pull(LPTIM_IN1, false);
    lptim_pull(LPTIM_IN2, false);
    for (uint32_t mode = 0; mode < 3; ++mode) {
        static const char *const up[] = {"rising-edges", "falling-edges", "all-edges"};
        open_anew(LPTIM_ENC | mode << 1, 0, 0xFFFF, 0xFFFF, LPTIM_CNTSTRT);
        wait_cycles(SETTLED);
        turn(8, true);
        check_equal(up[mode], LPTIM1->CNT, mode == 2 ? 32 : 16);
    }
    LPTIM1->ICR = LPTIM_ALL;
    turn(4, false);
    check_equal("and-back", LPTIM1->CNT, 16);
    check_equal("DOWN", take_flags(), LPTIM_DOWN);
    turn(1, true);
    check_equal("UP", take_flags(), LPTIM_UP);
    turn(6, false);
    check_equal("below-zero-is-ARR", LPTIM1->CNT, 0xFFFC);
}

void lptim_check_block(void)
{
    after_reset();
    synchronization();
    prescaler();
    continuous();
    late_enable();
    comparing();
    single();
    preload();
    output();
    triggers();
    inputs();
    encoder();
    lptim_reset();
}
