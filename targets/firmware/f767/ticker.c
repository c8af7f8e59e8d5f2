// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: an operating system's two tickers, TIM5 for microseconds and LPTIM1 for low power, and a program that
// sleeps between alarms as its sleep manager lets it: in Sleep until the alarm has reached the timer, then in Stop mode, which
// ends on HSI. LD1 toggles with each alarm; USART3 (115200 8N1) says how many ticks it came late, which is never early.

#include <stdint.h>

#include "chip/cpu.h"
#include "f767/clock.h"
#include "f767/lp_ticker.h"
#include "f767/registers.h"

#define BAUD 115200u
#define LD1 0
#define TICKS 0xFFFFu
#define RCC_APB1_TIM5 (1u << 3)
#define TIM5_CR1 (*(volatile uint32_t *)0x40000C00u)
#define TIM5_EGR (*(volatile uint32_t *)0x40000C14u)
#define TIM5_CNT (*(volatile uint32_t *)0x40000C24u)
#define TIM5_PSC (*(volatile uint32_t *)0x40000C28u)
#define PWR_CR1_LPDS (1u << 0)

static volatile uint32_t target;
static volatile int32_t late; // negative: it has not come yet

static void us_ticker_init(void)
{
    RCC->APB1ENR |= RCC_APB1_TIM5;
    TIM5_PSC = 2 * PCLK1_HZ / 1000000u - 1;
    TIM5_EGR = 1;
    TIM5_CR1 = 1;
}

static void start_usart(void)
{
    RCC->AHB1ENR |= RCC_AHB1_GPIO('B') | RCC_AHB1_GPIO('D');
    RCC->APB1ENR |= RCC_APB1_USART3;
    pin_mode('B', LD1, PIN_OUTPUT);
    pin_alternate('D', 8, 7);
    USART3->BRR = (PCLK1_HZ + BAUD / 2) / BAUD;
    USART3->CR1 = USART_CR1_UE | USART_CR1_TE;
}

static void say(const char *text)
{
    for (; *text; ++text) {
        while (!(USART3->ISR & USART_ISR_TXE)) {
        }
        USART3->TDR = (uint8_t)*text;
    }
    while (!(USART3->ISR & 1u << 6)) { // TC: nothing may be under way when the clock stops
    }
}

static void say_number(uint32_t number)
{
    char digits[11], *at = digits + sizeof digits;
    *--at = 0;
    do
        *--at = (char)('0' + number % 10);
    while (number /= 10);
    say(at);
}

// One that comes early, as at the end of a period, is asked for again.
void lp_ticker_irq_handler(void)
{
    int32_t since = (int16_t)(lp_ticker_read() - target);
    if (since < 0)
        lp_ticker_set_interrupt(target);
    else
        late = since;
}

static void idle(void)
{
    irq_disable(); // what is pending ends the sleep all the same, and is served with the fast clock
    if (late < 0 && lp_ticker_allows_stop()) {
        PWR->CR1 |= PWR_CR1_LPDS;
        SCB->SCR |= SCR_SLEEPDEEP;
        DSB();
        WFI();
        SCB->SCR &= ~SCR_SLEEPDEEP;
        if ((RCC->CFGR & RCC_CFGR_SWS) >> 2 != RCC_CFGR_SW_PLL)
            clock_start();
    } else if (late < 0) {
        WFI();
    }
    irq_enable();
}

static void await(uint32_t ticks)
{
    late = -1;
    target = (lp_ticker_read() + ticks) & TICKS;
    lp_ticker_set_interrupt(target);
    while (late < 0)
        idle();
    pin_write('B', LD1, !pin_read('B', LD1));
    say_number(ticks);
    say(" ticks, late by ");
    say_number((uint32_t)late);
    say("\r\n");
}

// Asked for again before the first has reached the timer, which Mbed's queue does whenever an earlier event comes in.
static void change_ones_mind(void)
{
    lp_ticker_set_interrupt((lp_ticker_read() + 30000) & TICKS);
    await(100);
}

int main(void)
{
    clock_start();
    start_usart();
    us_ticker_init();
    lp_ticker_init();
    say("tickers run\r\n");
    static const uint16_t delays[] = {3277, 1, 4, 33, 300, 20000};
    for (uint32_t i = 0; i < sizeof delays / sizeof *delays; ++i)
        await(delays[i]);
    change_ones_mind();
    uint32_t us = TIM5_CNT;
    late = -1;
    target = lp_ticker_read();
    lp_ticker_fire_interrupt();
    while (late < 0) {
    }
    say(TIM5_CNT - us < 100 ? "fired at once\r\n" : "fired late\r\n");
    for (uint32_t i = 0; i < 2; ++i)
        await(28000); // one of these passes the end of the period
    say("enough\r\n");
    for (;;)
        WFI();
}
