// SPDX-License-Identifier: GPL-2.0-or-later
//
// What the timers of the STM32F7 have beyond those of the F1 (RM0410, sections 25 to 28): 32 bits, the copy of UIF, compare
// units without pins, a second break, basic timers, small ones, triggers between them. Uses PC6 and PE9, to which nothing
// is attached on a Nucleo-144.

#include "check.h"
#include "f767/blocks.h"
#include "f767/clock.h"

#define TICK 2 // cycles of HCLK to a tick of a timer on APB1: twice PCLK1

static void sizes(void)
{
    check_equal("ARR-32", TIM2->ARR, 0xFFFFFFFF);
    check_equal("ARR-16", TIM3->ARR, 0xFFFF);
    TIM2->CNT = 0xFFFFFFFF;
    TIM3->CNT = 0xFFFFFFFF;
    check_equal("CNT-32", TIM2->CNT, 0xFFFFFFFF);
    check_equal("CNT-16", TIM3->CNT, 0xFFFF);
    TIM2->CCR[3] = 0x89ABCDEF;
    check_equal("CCR-32", TIM2->CCR[3], 0x89ABCDEF);
    check_equal("basic-timers-have-no-CCR", TIM6->CCR[0], 0);
    TIM1->RCR = 0xFFFF;
    check_equal("RCR-16", TIM1->RCR, 0xFFFF);
    TIM1->RCR = 0;
    TIM3->CNT = 0;
}

static void counting(void)
{
    TIM2->CNT = 0xFFF0;
    TIM2->CR1 = TIM_CEN;
    uint32_t start = DWT->CYCCNT, from = TIM2->CNT;
    wait_cycles(10000);
    uint32_t to = TIM2->CNT, took = DWT->CYCCNT - start;
    TIM2->CR1 = 0;
    check_range("twice-pclk1", to - from, took / TICK - 30, took / TICK + 30);
    check("beyond-16-bits", to > 0xFFFF);
}

static void copy_of_uif(void)
{
    TIM6->ARR = 99;
    TIM6->DIER = 1;
    TIM6->EGR = TIM_UG;
    TIM6->SR = 0;
    forget(TIM6_DAC_IRQ);
    TIM6->CR1 = TIM_CEN | TIM_UIFREMAP;
    uint32_t before = TIM6->CNT;
    wait_cycles(100 * TICK + 20);
    uint32_t after = TIM6->CNT;
    check_equal("UIFCPY-clear", before & TIM_UIFCPY, 0);
    check_equal("UIFCPY-set", after & TIM_UIFCPY, TIM_UIFCPY);
    check_range("beside-the-count", after & 0xFFFF, 0, 99);
    check_equal("TIM6-asks", pending(TIM6_DAC_IRQ), 1);
    TIM6->CR1 = 0;
    TIM6->SR = 0;
    check_equal("it-is-a-copy", TIM6->CNT & TIM_UIFCPY, 0);
    TIM6->CR1 = TIM_OPM | TIM_CEN;
    wait_cycles(300 * TICK);
    check_equal("one-pulse", TIM6->CR1 & TIM_CEN, 0);
}

static void units_without_pins(void)
{
    TIM1->ARR = 999;
    TIM1->CCR5 = 500;
    TIM1->CCR6 = 2000;
    TIM1->EGR = TIM_UG;
    TIM1->SR = 0;
    TIM1->CR1 = TIM_CEN;
    wait_cycles(300);
    uint32_t early = TIM1->SR;
    wait_cycles(400);
    uint32_t late = TIM1->SR;
    wait_cycles(500);
    uint32_t last = TIM1->SR;
    TIM1->CR1 = 0;
    check_equal("neither", early & (TIM_CC5IF | TIM_CC6IF), 0);
    check_equal("CC5IF", late & (TIM_CC5IF | TIM_CC6IF), TIM_CC5IF);
    check_equal("CC6IF-at-the-overflow", last & (TIM_CC5IF | TIM_CC6IF), TIM_CC5IF | TIM_CC6IF);
    TIM1->SR = ~TIM_CC5IF;
    check_equal("cleared-alone", TIM1->SR & (TIM_CC5IF | TIM_CC6IF), TIM_CC6IF);
}

// OC1 of TIM1 is forced active at PE9 until a break takes it away; a pull-down shows that.
static void breaks(void)
{
    TIM1->CCMR[0] = 5u << 4;
    TIM1->CCER = 1;
    TIM1->BDTR = TIM_MOE;
    GPIO('E')->PUPDR = 2u << 2 * 9;
    pin_alternate('E', 9, 1);
    wait_cycles(20);
    check_equal("driven", pin_read('E', 9), 1);
    TIM1->SR = 0;
    TIM1->DIER = 1u << 7;
    forget(TIM1_BRK_TIM9_IRQ);
    TIM1->EGR = TIM_B2G;
    wait_cycles(20);
    check_equal("B2IF", TIM1->SR & (TIM_BIF | TIM_B2IF), TIM_B2IF);
    check_equal("MOE-gone", TIM1->BDTR & TIM_MOE, 0);
    check_equal("released", pin_read('E', 9), 0);
    check_equal("break-asks", pending(TIM1_BRK_TIM9_IRQ), 1);
    TIM1->SR = 0;
    forget(TIM1_BRK_TIM9_IRQ);
    check_equal("asks-no-more", pending(TIM1_BRK_TIM9_IRQ), 0);
    TIM9->DIER = 1;
    TIM9->EGR = TIM_UG;
    DSB();
    check_equal("TIM9-shares-it", pending(TIM1_BRK_TIM9_IRQ), 1);
    TIM1->EGR = TIM_B2G;
    TIM1->SR = 0; // says nothing about TIM9's
    forget(TIM1_BRK_TIM9_IRQ);
    check_equal("and-holds-it", pending(TIM1_BRK_TIM9_IRQ), 1);
    TIM9->DIER = 0;
    TIM9->SR = 0;
    forget(TIM1_BRK_TIM9_IRQ);
    check_equal("until-both-are-done", pending(TIM1_BRK_TIM9_IRQ), 0);
}

static void triggers(void)
{
    // TIM9 counts the pulses of OC1REF of TIM10, which is behind its ITR2.
    TIM10->ARR = 99;
    TIM10->CCR[0] = 50;
    TIM10->CCMR[0] = TIM_PWM1;
    TIM10->EGR = TIM_UG;
    TIM9->CNT = 0;
    TIM9->SMCR = 2u << 4 | 7;
    TIM9->CR1 = TIM_CEN;
    TIM10->CR1 = TIM_CEN;
    wait_cycles(1020);
    TIM10->CR1 = 0;
    check_range("TIM9-counts-TIM10", TIM9->CNT, 10, 12);
    // UG of TIM1 resets and starts TIM2 in the combined mode.
    TIM2->CNT = 1000000;
    TIM2->SMCR = 1u << 16;
    TIM1->EGR = TIM_UG;
    wait_cycles(100);
    TIM2->CR1 &= ~TIM_CEN;
    check_range("reset-and-started", TIM2->CNT, 40, 200);
    TIM2->SMCR = 0;
}

static void pwm(void)
{
    TIM3->ARR = 999;
    TIM3->CCR[0] = 250;
    TIM3->CCMR[0] = TIM_PWM1 | 1u << 3;
    TIM3->CCER = 1;
    TIM3->EGR = TIM_UG;
    pin_alternate('C', 6, 2);
    TIM3->CR1 = TIM_CEN;
    uint32_t high = 0, samples = 20000;
    for (uint32_t i = 0; i < samples; ++i)
        high += pin_read('C', 6);
    check_range("a-quarter-of-the-time", high, samples * 24 / 100, samples * 26 / 100);
}

int main(void)
{
    cycles_start();
    clock_start();
    RCC->AHB1ENR |= RCC_AHB1_GPIO('C') | RCC_AHB1_GPIO('E');
    RCC->APB1ENR |= RCC_APB1_TIM(2) | RCC_APB1_TIM(3) | RCC_APB1_TIM(6);
    RCC->APB2ENR |= RCC_APB2_TIM1 | RCC_APB2_TIM9 | RCC_APB2_TIM10;
    sizes();
    counting();
    copy_of_uif();
    units_without_pins();
    breaks();
    triggers();
    pwm();
    check_done();
}
