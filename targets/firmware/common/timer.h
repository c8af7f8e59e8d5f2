// SPDX-License-Identifier: GPL-2.0-or-later
//
// What the timer self-tests share: timers fresh from reset, and the step by step clock.

#pragma once

#include "chip/stm32f103.h"
#include "cycles.h"

typedef volatile tim_t *timer_t;

// Puts all timers into the state after reset, with their clocks on.
static inline void timers_reset(void)
{
    RCC->APB1ENR |= RCC_APB1_TIM2 | RCC_APB1_TIM3 | RCC_APB1_TIM4;
    RCC->APB2ENR |= RCC_APB2_TIM1;
    RCC->APB1RSTR = RCC_APB1_TIM2 | RCC_APB1_TIM3 | RCC_APB1_TIM4;
    RCC->APB2RSTR = RCC_APB2_TIM1;
    RCC->APB1RSTR = 0;
    RCC->APB2RSTR = 0;
}

// What is written to the registers of one timer takes a few cycles to reach another.
static inline void timer_settle(void)
{
    DSB();
    for (int i = 0; i < 8; ++i)
        NOP();
}

// Makes `timer` count once for each timer_step(): TIM2's trigger output, which repeats its UG bit (MMS = 000), is the
// external clock. So a test sees every single count. ITR1 is TIM2 for TIM1, TIM3 and TIM4 alike (tables 82 and 86).
static inline void timer_clock_by_steps(timer_t timer)
{
    TIM2->CR2 = TIM_TRGO_RESET << TIM_CR2_MMS_SHIFT;
    timer->SMCR = TIM_TS_ITR(1) | TIM_SLAVE_EXTERNAL;
}

static inline void timer_step(void)
{
    TIM2->EGR = TIM_EGR_UG;
    timer_settle();
}

static inline void timer_steps(uint32_t count)
{
    while (count--)
        timer_step();
}

// The next `count` values of CNT as hexadecimal digits, the first the highest.
static inline uint32_t timer_trail(timer_t timer, uint32_t count)
{
    uint32_t trail = 0;
    while (count--) {
        timer_step();
        trail = trail << 4 | (timer->CNT & 0xF);
    }
    return trail;
}

// Loads the preloaded registers, as an update event does, and leaves no flag behind.
static inline void timer_load(timer_t timer)
{
    timer->EGR = TIM_EGR_UG;
    timer_settle();
    timer->SR = 0;
}
