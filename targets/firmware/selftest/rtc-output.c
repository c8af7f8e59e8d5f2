// SPDX-License-Identifier: GPL-2.0-or-later
//
// What the real-time clock puts out at the TAMPER pin (RM0008, sections 6.3.2 and 6.4.2): RTCCLK / 64, seconds, alarms. On LSI,
// 30 to 60 kHz (DS5319); a "second" is 40 ticks. HCLK is 8 MHz (HSI). PC13 must be free; an LED at it may be.

#include "check.h"
#include "chip/power.h"
#include "chip/rtc.h"
#include "chip/stm32f103.h"
#include "cycles.h"
#include "pin.h"
#include "wait.h"

#define PIN 13
#define SECOND 40u
#define FASTEST(ticks) ((ticks) * 8000000u / 60000u)
#define SLOWEST(ticks) ((ticks) * 8000000u / 30000u)
#define CCO (1u << 7)
#define ASOE (1u << 8)
#define ASOS (1u << 9)

static bool wait_for(bool level) { return wait_until(pin_read(GPIOC, PIN) == level); }

// Waits for a rising edge.
static bool rise(void) { return wait_for(false) && wait_for(true); }

static void write(uint32_t counter, uint32_t alarm)
{
    wait_until(RTC->CRL & RTC_CRL_RTOFF);
    RTC->CRL |= RTC_CRL_CNF;
    RTC->PRLH = 0;
    RTC->PRLL = SECOND - 1;
    RTC->CNTH = 0;
    RTC->CNTL = counter;
    RTC->ALRH = 0;
    RTC->ALRL = alarm;
    RTC->CRL &= ~RTC_CRL_CNF;
    wait_until(RTC->CRL & RTC_CRL_RTOFF);
}

static void start(void)
{
    PWR->CR |= PWR_CR_DBP;
    RCC->BDCR |= RCC_BDCR_BDRST;
    RCC->BDCR &= ~RCC_BDCR_BDRST;
    RCC->CSR |= RCC_CSR_LSION;
    wait_until(RCC->CSR & RCC_CSR_LSIRDY);
    RCC->BDCR |= RCC_BDCR_RTC_LSI;
    RCC->BDCR |= RCC_BDCR_RTC_ON;
    RTC->CRL &= ~RTC_CRL_RSF;
    wait_until(RTC->CRL & RTC_CRL_RSF);
}

static void clock(void)
{
    pin_pull(GPIOC, PIN, true);
    BKP->RTCCR = CCO;
    bool first = rise();
    uint32_t begin = cycles();
    bool second = rise();
    uint32_t took = cycles() - begin;
    check("a-clock-over-a-pull-up", first && second);
    check_range("rtcclk-by-64", took, FASTEST(64) - 60, SLOWEST(64) + 60);
    wait_for(false);
    BKP->RTCCR = 0;
    check("without-cco-the-port-has-it", pin_read(GPIOC, PIN));
}

static void seconds(void)
{
    write(0, 0xFFFF);
    BKP->RTCCR = ASOE | ASOS;
    rise();
    uint32_t begin = cycles();
    wait_for(false);
    uint32_t width = cycles() - begin;
    rise();
    uint32_t period = cycles() - begin;
    check_range("a-pulse-of-one-tick", width, FASTEST(1) - 60, SLOWEST(1) + 60);
    check_range("each-second", period, FASTEST(SECOND) - 60, SLOWEST(SECOND) + 60);
    check_equal("though-secf-stays", RTC->CRL & RTC_CRL_SECF, RTC_CRL_SECF);
    wait_for(false);
    pin_mode(GPIOC, PIN, PIN_OUTPUT);
    pin_write(GPIOC, PIN, true);
    check("whatever-the-port-says", !pin_read(GPIOC, PIN));
}

static void alarm(void)
{
    BKP->RTCCR = ASOE;
    write(10, 12);
    uint32_t begin = cycles(), pulses = 0;
    bool before = false;
    while (cycles() - begin < SLOWEST(5 * SECOND)) {
        bool now = pin_read(GPIOC, PIN);
        pulses += now && !before;
        before = now;
    }
    check_equal("an-alarm-is-one-pulse", pulses, 1);
    RCC->BDCR |= RCC_BDCR_BDRST;
    check("bdrst-ends-it", pin_read(GPIOC, PIN));
    RCC->BDCR &= ~RCC_BDCR_BDRST;
    pin_pull(GPIOC, PIN, true);
}

int main(void)
{
    cycles_start();
    RCC->APB1ENR |= RCC_APB1_PWR | RCC_APB1_BKP;
    RCC->APB2ENR |= RCC_APB2_GPIOC;
    start();
    clock();
    seconds();
    alarm();
    check_done();
}
