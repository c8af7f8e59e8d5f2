// SPDX-License-Identifier: GPL-2.0-or-later
//
// Window watchdog (RM0008, section 20): its three ways to reset the chip, its early warning, its time. At 8 MHz, PCLK1 too.

#include "check.h"
#include "chip/stm32f103.h"
#include "cycles.h"
#include "handlers.h"
#include "reset.h"
#include "startup.h"
#include "wait.h"

#define TICK 4096u // cycles of PCLK1, times 2^WDGTB
#define LATE 80u

static volatile uint32_t before_bite NOINIT; // cycles from a known moment to the last look

static uint32_t counter(void) { return WWDG->CR & WWDG_T; }

// --- Stage 0: registers and warning, then the counter runs out

static volatile uint32_t warnings;

void WWDG_IRQHandler(void)
{
    ++warnings;
    WWDG->SR = 0;
    WWDG->CR = WWDG_CR_WDGA | WWDG_T;
}

static void registers(void)
{
    check_equal("cr-reset", WWDG->CR & WWDG_CR_WDGA, 0);
    check_equal("cfr-reset", WWDG->CFR, 0x7F);
    check_equal("sr-reset", WWDG->SR, 0);
    WWDG->CFR = 3u << WWDG_CFR_TB_SHIFT | 0x7F;
    check_equal("cfr-reads-back", WWDG->CFR, 3u << WWDG_CFR_TB_SHIFT | 0x7F);
    WWDG->CFR = 0x7F;
}

// Once the watchdog runs, there are 33 ms for checks until it has to be refreshed again.
static void refresh(void) { WWDG->CR = WWDG_CR_WDGA | WWDG_T; }

static uint32_t tick_cycles(uint32_t tb)
{
    WWDG->CFR = tb << WWDG_CFR_TB_SHIFT | 0x7F;
    refresh();
    wait_until(counter() == 0x7D);
    uint32_t start = cycles();
    wait_until(counter() == 0x7A);
    uint32_t took = cycles() - start;
    refresh();
    return took;
}

static void counting(void)
{
    check_range("tick-of-4096", tick_cycles(0), 3 * TICK - LATE, 3 * TICK + LATE);
    check_range("tick-of-8192", tick_cycles(1), 3 * 2 * TICK - LATE, 3 * 2 * TICK + LATE);
    WWDG->CR = WWDG_T;
    check_equal("wdga-stays-on", WWDG->CR & WWDG_CR_WDGA, WWDG_CR_WDGA);
    refresh();
}

static void early_warning(void)
{
    WWDG->CFR = 0x7F; // EWI off: the flag comes all the same
    WWDG->CR = WWDG_CR_WDGA | 0x41;
    bool flagged = wait_until(WWDG->SR & WWDG_SR_EWIF);
    uint32_t count = counter();
    refresh();
    check("ewif-at-40", flagged);
    check_equal("counter-at-warning", count, 0x40);
    WWDG->SR = 0;
    check_equal("ewif-clears-on-writing-0", WWDG->SR, 0);
    irq_line_enable(WWDG_IRQ);
    WWDG->CFR = WWDG_CFR_EWI | 0x7F;
    WWDG->CR = WWDG_CR_WDGA | 0x42;
    bool warned = wait_until(warnings == 1);
    irq_line_disable(WWDG_IRQ);
    refresh();
    check("warning-interrupt", warned);
    WWDG->CFR = 0x7F;
    check_equal("ewi-stays-on", WWDG->CFR & WWDG_CFR_EWI, WWDG_CFR_EWI);
}

__attribute__((noreturn)) static void run_out(void)
{
    check_next_stage(1);
    WWDG->CR = WWDG_CR_WDGA | 0x50;
    wait_until(counter() == 0x4F);
    for (uint32_t start = cycles();;)
        before_bite = cycles() - start;
}

// --- Stage 1: a refresh outside the window, counter above W, resets at once

static void expect_cause(const char *name, uint32_t cause) { check_equal(name, cause, RCC_CSR_WWDGRSTF | RCC_CSR_PINRSTF); }

__attribute__((noreturn)) static void refresh_too_early(void)
{
    check_next_stage(2);
    WWDG->CFR = 0x50;
    WWDG->CR = WWDG_CR_WDGA | 0x60;
    wait_until(counter() == 0x4F);
    WWDG->CR = WWDG_CR_WDGA | 0x60; // within the window: allowed
    before_bite = 1;
    wait_until(counter() == 0x5E);
    before_bite = 2;
    WWDG->CR = WWDG_CR_WDGA | 0x60;
    wait_cycles(TICK); // the reset takes a few cycles
    before_bite = 3;
    check("refresh-outside-window-resets", false);
    check_done();
}

// --- Stage 2: bit T6 written 0 resets at once

__attribute__((noreturn)) static void clear_t6(void)
{
    check_next_stage(3);
    WWDG->CR = WWDG_CR_WDGA | 0x3F;
    wait_cycles(TICK);
    check("clearing-t6-resets", false);
    check_done();
}

int main(void)
{
    uint32_t cause = reset_cause();
    cycles_start();
    uint32_t stage = check_stage(cause & RCC_CSR_WWDGRSTF);
    RCC->APB1ENR |= RCC_APB1_WWDG;
    switch (stage) {
    case 0:
        registers();
        counting();
        early_warning();
        run_out();
    case 1:
        expect_cause("cause-of-running-out", cause);
        check_range("runs-out-after-3f", before_bite, 16 * TICK - LATE, 16 * TICK + LATE);
        refresh_too_early();
    case 2:
        expect_cause("cause-of-early-refresh", cause);
        check_equal("refresh-outside-window-only", before_bite, 2);
        clear_t6();
    default:
        expect_cause("cause-of-clearing-t6", cause);
        check_equal("watchdog-is-off-after-reset", WWDG->CR & WWDG_CR_WDGA, 0);
        check_done();
    }
}
