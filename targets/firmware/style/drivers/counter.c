// SPDX-License-Identifier: GPL-2.0-or-later
//
// The RTC as a counter of hundredths of a second, on the crystal of 8 MHz (RM0008, section 18). Its alarm comes by EXTI line 17.

#include "chip/rtc.h"

#include "chip/stm32f103.h"
#include "device.h"

#define RTC_HSE (3u << 8)
#define PRESCALER (8000000u / 128u / 100u - 1u)

static struct {
    const struct device *device;
    alarm_callback *callback;
    void *argument;
} state;

static void set(volatile uint32_t *high, uint32_t value)
{
    while (!(RTC->CRL & RTC_CRL_RTOFF)) {
    }
    RTC->CRL |= RTC_CRL_CNF;
    high[0] = value >> 16;
    high[1] = value & 0xFFFF;
    RTC->CRL &= ~RTC_CRL_CNF;
    while (!(RTC->CRL & RTC_CRL_RTOFF)) {
    }
}

static uint32_t value(const struct device *device)
{
    (void)device;
    for (;;) {
        uint32_t high = RTC->CNTH, low = RTC->CNTL;
        if (high == RTC->CNTH)
            return high << 16 | low;
    }
}

static void alarm_isr(const void *argument)
{
    (void)argument;
    EXTI->PR = 1u << RTC_ALARM_LINE;
    RTC->CRL &= ~RTC_CRL_ALRF;
    if (state.callback)
        state.callback(state.device, value(state.device), state.argument);
}

// ALR names the tick at whose end the alarm comes, while the counter still shows it (RM0008, figure 180): so it comes when
// `ticks` of them are over, and before another one is.
static int set_alarm(const struct device *device, uint32_t ticks, alarm_callback *callback, void *argument)
{
    state.device = device;
    state.callback = callback;
    state.argument = argument;
    set(&RTC->ALRH, value(device) + ticks);
    return 0;
}

const struct counter_api rtc_stm32 = {value, set_alarm};

int rtc_stm32_init(const struct device *device)
{
    (void)device;
    RCC->APB1ENR |= RCC_APB1_PWR | RCC_APB1_BKP;
    PWR->CR |= PWR_CR_DBP;
    RCC->BDCR |= RCC_BDCR_BDRST;
    RCC->BDCR &= ~RCC_BDCR_BDRST;
    RCC->BDCR |= RTC_HSE | RCC_BDCR_RTC_ON;
    RTC->CRL &= ~RTC_CRL_RSF;
    while (!(RTC->CRL & RTC_CRL_RSF)) {
    }
    set(&RTC->PRLH, PRESCALER);
    EXTI->RTSR |= 1u << RTC_ALARM_LINE;
    EXTI->IMR |= 1u << RTC_ALARM_LINE;
    irq_connect(RTC_ALARM_IRQ, alarm_isr, 0);
    return 0;
}
