// SPDX-License-Identifier: GPL-2.0-or-later
//
// Independent watchdog (RM0008, section 19). It is let bite, and what the chip says after it is checked. The test stays on
// HSI, 8 MHz; LSI is anything from 30 to 60 kHz (DS5319, table 25).

#include "check.h"
#include "chip/stm32f103.h"
#include "cycles.h"
#include "reset.h"
#include "startup.h"
#include "wait.h"

#define HCLK_PER_MS 8000u
#define BITE_TICKS 25u    // of LSI / 16: 10 ms at 40 kHz
#define BITE_MIN (BITE_TICKS * 16u * 1000u / 60u * (HCLK_PER_MS / 1000u))
#define BITE_MAX (BITE_TICKS * 16u * 1000u / 30u * (HCLK_PER_MS / 1000u))

static volatile struct {
    uint32_t cycles; // from the start of the watchdog to the last time anybody was there to look
    uint32_t kept;
} before_bite NOINIT;

static bool update_done(uint32_t flag) { return wait_until(!(IWDG->SR & flag)); }

static void registers(void)
{
    check_equal("pr-reset", IWDG->PR, 0);
    check_equal("rlr-reset", IWDG->RLR, 0xFFF);
    check_equal("sr-reset", IWDG->SR, 0);
    check_equal("kr-reads-0", IWDG->KR, 0);
    IWDG->PR = 3;
    check_equal("pr-is-protected", IWDG->PR, 0);
    check_equal("no-update-of-protected", IWDG->SR, 0);
    RCC->CSR |= RCC_CSR_LSION;
    check("lsi-gets-ready", wait_until(RCC->CSR & RCC_CSR_LSIRDY));
    IWDG->KR = IWDG_KEY_UNLOCK;
    IWDG->PR = 3;
    check_equal("update-sets-pvu", IWDG->SR & IWDG_SR_PVU, IWDG_SR_PVU);
    check("pvu-clears", update_done(IWDG_SR_PVU));
    check_equal("pr-updated", IWDG->PR, 3);
    IWDG->RLR = 0xABC;
    check_equal("update-sets-rvu", IWDG->SR & IWDG_SR_RVU, IWDG_SR_RVU);
    check("rvu-clears", update_done(IWDG_SR_RVU));
    check_equal("rlr-updated", IWDG->RLR, 0xABC);
    IWDG->KR = IWDG_KEY_RELOAD;
    IWDG->RLR = 0x123;
    check_equal("other-key-protects", IWDG->RLR, 0xABC);
    RCC->CSR &= ~RCC_CSR_LSION;
    wait_until(!(RCC->CSR & RCC_CSR_LSIRDY));
}

static void feeding(void)
{
    IWDG->KR = IWDG_KEY_START;
    check("start-forces-lsi-on", wait_until(RCC->CSR & RCC_CSR_LSIRDY)); // 7.2.5
    IWDG->KR = IWDG_KEY_UNLOCK;
    IWDG->PR = 2;
    IWDG->RLR = BITE_TICKS - 1;
    update_done(IWDG_SR_PVU);
    update_done(IWDG_SR_RVU);
    for (int i = 0; i < 10; ++i) { // twice the longest time in all, half the shortest at once
        IWDG->KR = IWDG_KEY_RELOAD;
        wait_cycles(BITE_MIN / 2);
    }
    check("feeding-keeps-it-quiet", true);
}

// Each turn of the loop may be the last; a reset leaves RAM as it is.
__attribute__((noreturn)) static void starve(void)
{
    before_bite.kept = 0x600DCAFE;
    check_next_stage(1);
    IWDG->KR = IWDG_KEY_RELOAD;
    for (uint32_t start = cycles();;)
        before_bite.cycles = cycles() - start;
}

static void after_bite(uint32_t cause)
{
    check_equal("cause-is-iwdg-and-pin", cause, RCC_CSR_IWDGRSTF | RCC_CSR_PINRSTF);
    check_equal("causes-cleared", RCC->CSR & RCC_CSR_CAUSES, 0);
    check_equal("ram-is-kept", before_bite.kept, 0x600DCAFE);
    check_range("bites-in-time", before_bite.cycles, BITE_MIN, BITE_MAX);
    check_equal("pr-reset-by-bite", IWDG->PR, 0);
    check_equal("stopped-by-bite", RCC->CSR & RCC_CSR_LSIRDY, 0);
    wait_cycles(2 * BITE_MAX);
    check("does-not-bite-again", true);
}

int main(void)
{
    uint32_t cause = reset_cause();
    cycles_start();
    if (check_stage(cause & RCC_CSR_IWDGRSTF) == 0) {
        registers();
        feeding();
        starve();
    }
    after_bite(cause);
    check_done();
}
