// SPDX-License-Identifier: GPL-2.0-or-later
//
// Power control and backup registers (RM0008, sections 5 and 6): write protection, what a reset keeps, the voltage
// detector, sleep, Stop that something pending prevents, Standby that the independent watchdog ends.

#include "check.h"
#include "chip/stm32f103.h"
#include "clock.h"
#include "cycles.h"
#include "handlers.h"
#include "pin.h"
#include "reset.h"
#include "startup.h"
#include "wait.h"

static uint32_t kept_in_ram NOINIT;

// --- Backup registers (6.3.1, 5.1.2)

static void protection(void)
{
    PWR->CR &= ~PWR_CR_DBP;
    uint32_t before = BKP->DR[0];
    BKP->DR[0] = ~before & 0xFFFF;
    check_equal("bkp-is-protected", BKP->DR[0], before);
    PWR->CR |= PWR_CR_DBP;
    check("dbp-is-kept", PWR->CR & PWR_CR_DBP);
    uint32_t wrong = 0;
    for (uint32_t i = 0; i < 10; ++i)
        BKP->DR[i] = 0x1100 + i;
    for (uint32_t i = 0; i < 10; ++i)
        wrong += BKP->DR[i] != 0x1100 + i;
    check_equal("ten-registers", wrong, 0);
    BKP->DR[0] = 0x12345678;
    check_equal("sixteen-bits-each", BKP->DR[0], 0x5678);
    RCC->APB1RSTR = RCC_APB1_BKP | RCC_APB1_PWR; // not the way to clear them
    RCC->APB1RSTR = 0;
    check_equal("peripheral-reset-keeps-bkp", BKP->DR[0], 0x5678);
    check_equal("peripheral-reset-clears-dbp", PWR->CR & PWR_CR_DBP, 0);
    PWR->CR |= PWR_CR_DBP;
}

static void backup_reset(void)
{
    check_equal("bkp-kept-over-reset", BKP->DR[0], 0x5678);
    check_equal("ram-kept-over-reset", kept_in_ram, 0x0DDBA115);
    check_equal("dbp-cleared-by-reset", PWR->CR & PWR_CR_DBP, 0);
    PWR->CR |= PWR_CR_DBP;
    RCC->BDCR |= RCC_BDCR_BDRST;
    check_equal("bdrst-clears-bkp", BKP->DR[0], 0);
    RCC->BDCR &= ~RCC_BDCR_BDRST;
    BKP->DR[9] = 0xBEEF;
}

// --- Voltage detector (5.2.3): 3.3 V is above every threshold

static void voltage_detector(void)
{
    PWR->CR |= PWR_CR_PVDE | 7u << PWR_CR_PLS_SHIFT;
    wait_cycles(1000);
    check_equal("pvdo-is-0-at-3.3-v", PWR->CSR & PWR_CSR_PVDO, 0);
    PWR->CR &= ~(PWR_CR_PVDE | 7u << PWR_CR_PLS_SHIFT);
}

// --- Sleep (5.3.3)

static volatile uint32_t ticks;

void SysTick_Handler(void) { ++ticks; }

static void sleep(void)
{
    SYSTICK->LOAD = 20000 - 1;
    SYSTICK->VAL = 0;
    uint32_t begin = cycles();
    SYSTICK->CTRL = SYSTICK_CLKSOURCE | SYSTICK_TICKINT | SYSTICK_ENABLE;
    for (int i = 0; i < 5; ++i)
        WFI();
    uint32_t slept = cycles() - begin;
    SYSTICK->CTRL = 0;
    check_equal("five-sleeps", ticks, 5);
    check_range("sleeping-takes-its-time", slept, 100000, 100400);
}

// --- Stop is not entered while an EXTI line is pending (5.3.4): the clocks stay as they are

static void stop_prevented(void)
{
    clock_72mhz();
    RCC->APB2ENR |= RCC_APB2_AFIO;
    EXTI->IMR = 1u << 6;
    irq_disable();
    irq_line_enable(EXTI9_5_IRQ);
    EXTI->SWIER = 1u << 6;
    PWR->CR &= ~PWR_CR_PDDS;
    SCB->SCR = SCR_SLEEPDEEP;
    WFI();
    SCB->SCR = 0;
    check_equal("stop-is-not-entered", (RCC->CFGR & RCC_CFGR_SWS) >> RCC_CFGR_SWS_SHIFT, SYSCLK_PLL);
    EXTI->PR = 1u << 6;
    EXTI->IMR = 0;
    irq_line_disable(EXTI9_5_IRQ);
    irq_unpend(EXTI9_5_IRQ);
    irq_enable();
}

// --- Standby (5.3.5): RAM is lost, the watchdog's reset ends it, and PWR_CSR remembers

__attribute__((noreturn)) static void standby(void)
{
    PWR->CR |= PWR_CR_CWUF | PWR_CR_CSBF;
    wait_cycles(100);
    check_equal("csbf-clears-sbf", PWR->CSR & PWR_CSR_SBF, 0);
    check_equal("cwuf-clears-wuf", PWR->CSR & PWR_CSR_WUF, 0);
    // From here the tally cannot stay in RAM, which Standby loses: it goes to the backup registers
    check_keep(BKP->DR + 1);
    PWR->CR |= PWR_CR_DBP;
    IWDG->KR = IWDG_KEY_START;
    IWDG->KR = IWDG_KEY_UNLOCK;
    IWDG->RLR = 100;
    wait_until(!(IWDG->SR & IWDG_SR_RVU));
    IWDG->KR = IWDG_KEY_RELOAD;
    PWR->CR |= PWR_CR_PDDS;
    SCB->SCR = SCR_SLEEPDEEP;
    for (;;)
        WFI();
}

static void after_standby(uint32_t cause)
{
    check_equal("standby-flag", PWR->CSR & PWR_CSR_SBF, PWR_CSR_SBF);
    check_equal("woken-by-watchdog", cause & RCC_CSR_IWDGRSTF, RCC_CSR_IWDGRSTF);
    check_equal("bkp-kept-over-standby", BKP->DR[9], 0xBEEF);
    check_equal("clocks-as-after-reset", RCC->CFGR, 0);
    PWR->CR |= PWR_CR_CSBF;
    wait_cycles(100);
    check_equal("csbf-clears-again", PWR->CSR & PWR_CSR_SBF, 0);
}

int main(void)
{
    uint32_t cause = reset_cause();
    cycles_start();
    RCC->APB1ENR |= RCC_APB1_PWR | RCC_APB1_BKP;
    if (PWR->CSR & PWR_CSR_SBF) {
        check_resume(BKP->DR + 1);
        after_standby(cause);
        check_done();
    }
    if (check_stage(cause & RCC_CSR_SFTRSTF) == 0) {
        protection();
        kept_in_ram = 0x0DDBA115;
        check_next_stage(1);
        reset_by_software();
    }
    check_equal("cause-is-software-and-pin", cause, RCC_CSR_SFTRSTF | RCC_CSR_PINRSTF);
    backup_reset();
    voltage_detector();
    sleep();
    stop_prevented();
    standby();
}
