// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: a logger that sleeps most of the time. The RTC runs on the crystal of 32768 Hz and shows a date; on the
// first start it is set to 2024-02-28 23:59:50, later it is left as it is (a word in the backup registers says so). It
// says the date on USART1 (PA9), 115200 8N1, sleeps 15 s in Stop until an alarm of the RTC, says it again, then goes to Standby
// until the next alarm a minute later, which starts it anew.

#include "chip/rtc.h"
#include "chip/stm32f103.h"
#include "clock.h"
#include "handlers.h"
#include "pin.h"
#include "text.h"

#define BAUD 115200u
#define SET 0x5A5Au
#define FIRST 1709164790u // 2024-02-28 23:59:50 UTC, in seconds since 1970
#define DAY 86400u

void RTCAlarm_IRQHandler(void)
{
    EXTI->PR = 1u << RTC_ALARM_LINE;
    RTC->CRL &= ~RTC_CRL_ALRF;
}

static void send(const char *text)
{
    for (; *text; ++text) {
        while (!(USART1->SR & USART_SR_TXE)) {
        }
        USART1->DR = (uint8_t)*text;
    }
    while (!(USART1->SR & USART_SR_TC)) {
    }
}

static void wait_for_last_task(void)
{
    while (!(RTC->CRL & RTC_CRL_RTOFF)) {
    }
}

static void wait_for_synchro(void)
{
    RTC->CRL &= ~RTC_CRL_RSF;
    while (!(RTC->CRL & RTC_CRL_RSF)) {
    }
}

static void configure(volatile uint32_t *high, uint32_t value)
{
    wait_for_last_task();
    RTC->CRL |= RTC_CRL_CNF;
    high[0] = value >> 16;
    high[1] = value & 0xFFFF;
    RTC->CRL &= ~RTC_CRL_CNF;
    wait_for_last_task();
}

static uint32_t now(void)
{
    for (;;) {
        uint32_t high = RTC->CNTH, low = RTC->CNTL;
        if (high == RTC->CNTH)
            return high << 16 | low;
    }
}

static void two(struct line *line, uint32_t value)
{
    if (value < 10)
        line_text(line, "0");
    line_decimal(line, value);
}

// Days since 1970 as a date; by eras of 400 years that begin in March.
static void say(const char *what)
{
    uint32_t seconds = now(), days = seconds / DAY + 719468u, era = days / 146097u, day = days % 146097u;
    uint32_t year = (day - day / 1460u + day / 36524u - day / 146096u) / 365u;
    day -= 365u * year + year / 4u - year / 100u;
    uint32_t month = (5u * day + 2u) / 153u;
    day -= (153u * month + 2u) / 5u;
    month = month < 10u ? month + 3u : month - 9u;
    year += 400u * era + (month <= 2u);
    struct line line = EMPTY_LINE;
    line_text(&line, what);
    line_decimal(&line, year);
    line_text(&line, "-");
    two(&line, month);
    line_text(&line, "-");
    two(&line, day + 1u);
    line_text(&line, " ");
    two(&line, seconds % DAY / 3600u);
    line_text(&line, ":");
    two(&line, seconds % 3600u / 60u);
    line_text(&line, ":");
    two(&line, seconds % 60u);
    line_text(&line, "\r\n");
    send(line.text);
}

static void start_clock(void)
{
    RCC->BDCR |= RCC_BDCR_BDRST;
    RCC->BDCR &= ~RCC_BDCR_BDRST;
    RCC->BDCR |= RCC_BDCR_LSEON;
    while (!(RCC->BDCR & RCC_BDCR_LSERDY)) {
    }
    RCC->BDCR |= RCC_BDCR_RTC_LSE;
    RCC->BDCR |= RCC_BDCR_RTC_ON;
    wait_for_synchro();
    configure(&RTC->PRLH, 32767);
    configure(&RTC->CNTH, FIRST);
    BKP->DR[0] = SET;
}

static void uart_on(void)
{
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE;
}

int main(void)
{
    clock_72mhz();
    RCC->APB1ENR |= RCC_APB1_PWR | RCC_APB1_BKP;
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_USART1;
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    uart_on();
    bool woken = PWR->CSR & PWR_CSR_SBF;
    PWR->CR |= PWR_CR_DBP | PWR_CR_CSBF | PWR_CR_CWUF;
    if (BKP->DR[0] != SET)
        start_clock();
    wait_for_synchro();
    say(woken ? "woken    " : "started  ");

    EXTI->RTSR |= 1u << RTC_ALARM_LINE;
    EXTI->IMR |= 1u << RTC_ALARM_LINE;
    irq_line_enable(RTC_ALARM_IRQ);
    configure(&RTC->ALRH, now() + 15);
    SCB->SCR |= SCR_SLEEPDEEP;
    PWR->CR = (PWR->CR & ~PWR_CR_PDDS) | PWR_CR_LPDS;
    WFI();
    clock_72mhz(); // Stop ends on HSI
    wait_for_synchro();
    say("stopped  ");

    configure(&RTC->ALRH, now() + 60);
    PWR->CR |= PWR_CR_PDDS | PWR_CR_CWUF;
    WFI();
    for (;;) {
    }
}
