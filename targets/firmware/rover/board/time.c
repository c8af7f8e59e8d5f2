// SPDX-License-Identifier: GPL-2.0-or-later
//
// TIM5 counts microseconds, SysTick makes the ticks.

#include "rover/board/time.h"

#include "chip/core.h"
#include "rover/board/clock.h"
#include "rover/chip/irq.h"
#include "rover/chip/rcc.h"
#include "rover/chip/tim.h"

#define SYSTICK_EXCEPTION 15
#define SYSTICK_LEVEL 3

static volatile uint32_t ticks;

void SysTick_Handler(void) { ++ticks; }

void time_start(void)
{
    RCC->APB1ENR |= RCC_APB1_TIM5;
    TIM5->PSC = TIMERS1_HZ / 1000000u - 1;
    TIM5->ARR = 0xFFFFFFFFu;
    TIM5->EGR = TIM_EGR_UG; // the prescaler counts from its new value at once
    TIM5->CR1 = TIM_CR1_CEN;

    SCB->SHPR[SYSTICK_EXCEPTION - 4] = SYSTICK_LEVEL << 4;
    SYSTICK->LOAD = HCLK_HZ / TICK_HZ - 1;
    SYSTICK->VAL = 0;
    SYSTICK->CTRL = SYSTICK_ENABLE | SYSTICK_TICKINT | SYSTICK_CLKSOURCE;
}

uint32_t time_us(void) { return TIM5->CNT; }

uint32_t time_ticks(void) { return ticks; }
