// SPDX-License-Identifier: GPL-2.0-or-later
//
// The real-time clock (RM0008, section 18). Each value enters and leaves configuration mode for itself, low half first.

#include "opencm3.h"

static void enter_config_mode(void)
{
    while (!(RTC->CRL & RTC_CRL_RTOFF)) {
    }
    RTC->CRL |= RTC_CRL_CNF;
}

static void exit_config_mode(void)
{
    RTC->CRL &= ~RTC_CRL_CNF;
    while (!(RTC->CRL & RTC_CRL_RTOFF)) {
    }
}

static void set(volatile uint32_t *high, uint32_t value)
{
    enter_config_mode();
    high[1] = value & 0xFFFF;
    high[0] = value >> 16;
    exit_config_mode();
}

static void awake_from_off(void)
{
    RCC->BDCR |= RCC_BDCR_BDRST;
    RCC->BDCR &= ~RCC_BDCR_BDRST;
    RCC->CSR |= RCC_CSR_LSION;
    while (!(RCC->CSR & RCC_CSR_LSIRDY)) {
    }
    RCC->BDCR = (RCC->BDCR & ~(3u << 8)) | RCC_BDCR_RTC_LSI;
    RCC->BDCR |= RCC_BDCR_RTC_ON;
}

void rtc_auto_awake_lsi(uint32_t prescaler)
{
    rcc_periph_clock_enable(RCC_GATE_PWR);
    rcc_periph_clock_enable(RCC_GATE_BKP);
    PWR->CR |= PWR_CR_DBP;
    if (!(RCC->BDCR & RCC_BDCR_RTC_ON))
        awake_from_off();
    RTC->CRH = 0;
    RTC->CRL &= ~RTC_CRL_RSF;
    while (!(RTC->CRL & RTC_CRL_RSF)) {
    }
    while (!(RTC->CRL & RTC_CRL_RTOFF)) {
    }
    set(&RTC->PRLH, prescaler);
}

void rtc_set_counter_val(uint32_t value) { set(&RTC->CNTH, value); }

void rtc_set_alarm_time(uint32_t value) { set(&RTC->ALRH, value); }

uint32_t rtc_get_counter_val(void) { return RTC->CNTH << 16 | RTC->CNTL; }

// CRH has the flags' bits in the same places as CRL.
void rtc_interrupt_enable(uint32_t flag)
{
    while (!(RTC->CRL & RTC_CRL_RTOFF)) {
    }
    RTC->CRH |= flag;
}

bool rtc_check_flag(uint32_t flag) { return RTC->CRL & flag; }

void rtc_clear_flag(uint32_t flag) { RTC->CRL &= ~flag; }
