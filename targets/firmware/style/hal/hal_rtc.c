// SPDX-License-Identifier: GPL-2.0-or-later
//
// The counter as a time of the day (RM0008, section 18), on the LSI. PRL and ALR are changed by reading them first, which gives 0.

#include "hal_buses.h"

#define TIMEOUT_MS 1000u

__attribute__((weak)) void hal_rtc_alarm_callback(void) {}

static hal_status_t wait_flag(uint32_t flag)
{
    uint32_t start = hal_get_tick();
    while (!(RTC->CRL & flag))
        if (hal_get_tick() - start > TIMEOUT_MS)
            return HAL_TIMEOUT;
    return HAL_OK;
}

static hal_status_t set(volatile uint32_t *high, uint32_t value)
{
    if (wait_flag(RTC_CRL_RTOFF) != HAL_OK)
        return HAL_ERROR;
    RTC->CRL |= RTC_CRL_CNF;
    high[0] = value >> 16;
    high[1] = (high[1] & ~0xFFFFu) | (value & 0xFFFF);
    RTC->CRL &= ~RTC_CRL_CNF;
    return wait_flag(RTC_CRL_RTOFF);
}

static void clock_from_lsi(void)
{
    RCC->APB1ENR |= RCC_APB1_PWR | RCC_APB1_BKP;
    PWR->CR |= PWR_CR_DBP;
    while (!(PWR->CR & PWR_CR_DBP)) {
    }
    RCC->CSR |= RCC_CSR_LSION;
    while (!(RCC->CSR & RCC_CSR_LSIRDY)) {
    }
    uint32_t kept = RCC->BDCR & ~(3u << 8);
    *bit_of(&RCC->BDCR, 16) = 1; // BDRST
    *bit_of(&RCC->BDCR, 16) = 0;
    RCC->BDCR = kept;
    RCC->BDCR |= RCC_BDCR_RTC_LSI;
    *bit_of(&RCC->BDCR, 15) = 1; // RTCEN
}

hal_status_t hal_rtc_init(uint32_t prescaler)
{
    clock_from_lsi();
    RTC->CRL &= ~RTC_CRL_RSF;
    if (wait_flag(RTC_CRL_RSF) != HAL_OK)
        return HAL_ERROR;
    RTC->CRL &= ~(RTC_CRL_OWF | RTC_CRL_ALRF | RTC_CRL_SECF);
    return set(&RTC->PRLH, prescaler);
}

static uint32_t seconds_of(hal_time_t time) { return time.hours * 3600u + time.minutes * 60u + time.seconds; }

hal_status_t hal_rtc_set_time(hal_time_t time) { return set(&RTC->CNTH, seconds_of(time)); }

hal_time_t hal_rtc_get_time(void)
{
    uint32_t before = RTC->CNTH, low = RTC->CNTL, after = RTC->CNTH;
    uint32_t count = before == after ? before << 16 | low : after << 16 | RTC->CNTL;
    return (hal_time_t){(uint8_t)(count / 3600 % 24), (uint8_t)(count / 60 % 60), (uint8_t)(count % 60)};
}

hal_status_t hal_rtc_set_alarm_it(hal_time_t time)
{
    if (set(&RTC->ALRH, seconds_of(time)) != HAL_OK)
        return HAL_ERROR;
    RTC->CRL &= ~RTC_CRL_ALRF;
    RTC->CRH |= RTC_CRL_ALRF; // ALRIE
    EXTI->IMR |= 1u << RTC_ALARM_LINE;
    EXTI->RTSR |= 1u << RTC_ALARM_LINE;
    return HAL_OK;
}

void hal_rtc_alarm_irq_handler(void)
{
    if (RTC->CRH & RTC_CRL_ALRF && RTC->CRL & RTC_CRL_ALRF) {
        hal_rtc_alarm_callback();
        RTC->CRL &= ~RTC_CRL_ALRF;
    }
    EXTI->PR = 1u << RTC_ALARM_LINE;
}
