// SPDX-License-Identifier: GPL-2.0-or-later
//
// Real-time clock (RM0008, section 18) on LSI, 30 to 60 kHz (DS5319): a "second" of this test is 40 ticks, 1 ms at 40 kHz. HCLK
// is 8 MHz (HSI). The test is reset once by itself.

#include "check.h"
#include "chip/rtc.h"
#include "chip/stm32f103.h"
#include "cycles.h"
#include "handlers.h"
#include "reset.h"
#include "startup.h"
#include "wait.h"

#define SECOND 40u
#define SHORTEST (SECOND * 8000000u / 60000u)
#define LONGEST (SECOND * 8000000u / 30000u)

static volatile uint32_t interrupts, alarms;
static uint32_t count_before NOINIT;

void RTC_IRQHandler(void)
{
    ++interrupts;
    RTC->CRL = 0;
}

void RTCAlarm_IRQHandler(void)
{
    ++alarms;
    EXTI->PR = 1u << RTC_ALARM_LINE;
}

static uint32_t count(void) { return RTC->CNTH << 16 | RTC->CNTL; }

static bool through(void) { return wait_until(RTC->CRL & RTC_CRL_RTOFF); }

static void configure(uint32_t prescaler, uint32_t counter, uint32_t alarm)
{
    through();
    RTC->CRL |= RTC_CRL_CNF;
    RTC->PRLH = prescaler >> 16;
    RTC->PRLL = prescaler & 0xFFFF;
    RTC->CNTH = counter >> 16;
    RTC->CNTL = counter & 0xFFFF;
    RTC->ALRH = alarm >> 16;
    RTC->ALRL = alarm & 0xFFFF;
    RTC->CRL &= ~RTC_CRL_CNF;
}

static bool second(void)
{
    RTC->CRL = ~RTC_CRL_SECF & 0xF;
    return wait_until(RTC->CRL & RTC_CRL_SECF);
}

static void start(void)
{
    PWR->CR |= PWR_CR_DBP;
    RCC->BDCR |= RCC_BDCR_BDRST;
    RCC->BDCR &= ~RCC_BDCR_BDRST;
    check_equal("crl-reset", RTC->CRL, RTC_CRL_RTOFF);
    check_equal("cnt-reset", count(), 0);
    RCC->CSR |= RCC_CSR_LSION;
    wait_until(RCC->CSR & RCC_CSR_LSIRDY);
    RCC->BDCR |= RCC_BDCR_RTC_LSI;
    RCC->BDCR |= RCC_BDCR_RTC_ON;
    RCC->BDCR = (RCC->BDCR & ~(3u << 8)) | RCC_BDCR_RTC_LSE;
    check_equal("rtcsel-is-chosen-once", RCC->BDCR & 3u << 8, RCC_BDCR_RTC_LSI);
    RTC->CRL &= ~RTC_CRL_RSF;
    check("rsf-rises", wait_until(RTC->CRL & RTC_CRL_RSF));
}

static void writing(void)
{
    RTC->CNTL = 5;
    through();
    check_equal("without-cnf-nothing-is-written", count(), 0);
    RTC->CRL |= RTC_CRL_CNF;
    RTC->CNTH = 0x12;
    RTC->CNTL = 0x3456;
    check("rtoff-in-configuration-mode", RTC->CRL & RTC_CRL_RTOFF);
    RTC->CRL &= ~RTC_CRL_CNF;
    check("rtoff-falls", !(RTC->CRL & RTC_CRL_RTOFF));
    check("rtoff-rises", through());
    check_equal("what-was-written", count(), 0x123456);
    check_equal("alarm-cannot-be-read", RTC->ALRL, 0);
    PWR->CR &= ~PWR_CR_DBP;
    RTC->CRH = 7;
    check_equal("dbp-protects", RTC->CRH, 0);
    PWR->CR |= PWR_CR_DBP;
}

static void counting(void)
{
    configure(SECOND - 1, 0xFFFFFFFEu, 0xFFFFFFFFu);
    through();
    RTC->CRL = 0;
    bool first = second();
    uint32_t begin = cycles();
    bool more = second();
    uint32_t took = cycles() - begin;
    check("secf", first && more);
    check_range("a-second", took, SHORTEST - 60, LONGEST + 60);
    check("alarm-of-the-second-that-has-ended", RTC->CRL & RTC_CRL_ALRF);
    check("with-it-the-overflow", RTC->CRL & RTC_CRL_OWF);
    wait_cycles(LONGEST / SECOND * 3);
    check_equal("behind-it-zero", count(), 0);
    RTC->CRL = ~RTC_CRL_OWF & 0xF;
    check_equal("flags-clear-by-0-alone", RTC->CRL & (RTC_CRL_OWF | RTC_CRL_ALRF), RTC_CRL_ALRF);
    uint32_t left = RTC->DIVL;
    wait_cycles(LONGEST / SECOND * 4);
    check_range("div-counts-down", (left - RTC->DIVL + SECOND) % SECOND, 3, 9);
}

static void interrupt(void)
{
    RTC->CRL = 0;
    RTC->CRH = RTC_CRL_SECF;
    interrupts = 0;
    irq_line_enable(RTC_IRQ);
    wait_cycles(LONGEST * 4);
    irq_line_disable(RTC_IRQ);
    RTC->CRH = 0;
    check_range("an-interrupt-a-second", interrupts, 3, 9);

    EXTI->IMR = EXTI->RTSR = 1u << RTC_ALARM_LINE;
    irq_line_enable(RTC_ALARM_IRQ);
    configure(SECOND - 1, 100, 102);
    through();
    RTC->CRL = 0;
    wait_cycles(SHORTEST * 2);
    uint32_t early = alarms;
    wait_cycles(LONGEST * 3);
    check_equal("no-alarm-before-its-time", early, 0);
    check_equal("an-alarm-by-exti-17", alarms, 1);
    irq_line_disable(RTC_ALARM_IRQ);
    EXTI->IMR = 0;
}

static void stop(void)
{
    EXTI->EMR = 1u << RTC_ALARM_LINE;
    EXTI->PR = 1u << RTC_ALARM_LINE;
    configure(SECOND - 1, 0, 20);
    through();
    RTC->CRL = 0;
    PWR->CR &= ~PWR_CR_PDDS;
    SCB->SCR |= SCR_SLEEPDEEP;
    WFE();
    WFE();
    SCB->SCR &= ~SCR_SLEEPDEEP;
    check("an-alarm-ends-stop", RTC->CRL & RTC_CRL_ALRF);
    wait_cycles(LONGEST / SECOND * 3);
    check_equal("it-counted-meanwhile", count(), 21);
    EXTI->EMR = 0;
}

static void before_reset(void)
{
    configure(SECOND - 1, 500, 0xFFFF);
    through();
    RTC->CRH = 7;
    count_before = count();
    check_next_stage(1);
    reset_by_software();
}

static void after_reset(void)
{
    check_equal("crh-cleared-by-reset", RTC->CRH, 0);
    check_range("the-counter-goes-on", count(), count_before, count_before + 3);
    PWR->CR |= PWR_CR_DBP;
    RCC->BDCR |= RCC_BDCR_BDRST;
    check_equal("bdrst-clears-it", count(), 0);
    RCC->BDCR &= ~RCC_BDCR_BDRST;
}

int main(void)
{
    cycles_start();
    RCC->APB1ENR |= RCC_APB1_PWR | RCC_APB1_BKP;
    if (check_stage(reset_cause() & RCC_CSR_SFTRSTF) == 0) {
        start();
        writing();
        counting();
        interrupt();
        stop();
        before_reset();
    }
    after_reset();
    check_done();
}
