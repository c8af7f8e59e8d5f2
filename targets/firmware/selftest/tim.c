// SPDX-License-Identifier: GPL-2.0-or-later
//
// The time base and the compare channels of the general-purpose timers (RM0008, 15.3.1 to 15.3.10), on TIM3 with outputs
// on PA6 and PA7 that are read back from the pins. Triggers, capture and encoder are in selftest/tim-inputs.c.

#include "check.h"
#include "chip/stm32f103.h"
#include "clock.h"
#include "pin.h"
#include "timer.h"
#include "wait.h"

#define POLL 40 // cycles that a polling loop may be late

static void fresh(uint32_t arr, uint32_t cr1)
{
    timers_reset();
    timer_clock_by_steps(TIM3);
    TIM3->ARR = arr;
    TIM3->CR1 = cr1;
    timer_load(TIM3);
    TIM3->CR1 = cr1 | TIM_CR1_CEN;
    timer_settle();
}

static uint32_t updated(void)
{
    uint32_t flag = TIM3->SR & TIM_UIF;
    TIM3->SR = ~TIM_UIF;
    return flag;
}

// --- Registers

static void registers(void)
{
    timers_reset();
    check_equal("arr-reset", TIM3->ARR, 0xFFFF);
    check_equal("cr1-reset", TIM3->CR1, 0);
    check_equal("sr-reset", TIM3->SR, 0);
    TIM3->CNT = 0x12345;
    check_equal("cnt-has-16-bits", TIM3->CNT, 0x2345);
    check_equal("stands-still-without-cen", TIM3->CNT, 0x2345);
    TIM3->EGR = TIM_EGR_UG;
    timer_settle();
    check_equal("egr-reads-0", TIM3->EGR, 0);
    check_equal("ug-clears-cnt", TIM3->CNT, 0);
    check_equal("ug-sets-uif", TIM3->SR & TIM_UIF, TIM_UIF);
    TIM3->SR = TIM_UIF;
    check_equal("uif-stays-on-writing-1", TIM3->SR & TIM_UIF, TIM_UIF);
    TIM3->SR = ~TIM_UIF;
    check_equal("uif-clears-on-writing-0", TIM3->SR & TIM_UIF, 0);
}

// --- Counting (15.3.2), count by count

static void counting(void)
{
    fresh(3, 0);
    check_equal("counts-up", timer_trail(TIM3, 6), 0x123012);
    check_equal("overflow-sets-uif", updated(), 1);
    fresh(3, 0);
    timer_steps(3);
    check_equal("no-uif-at-arr", updated(), 0);
    timer_step();
    check_equal("uif-after-arr", updated(), 1);

    fresh(3, TIM_CR1_DIR);
    check_equal("down-starts-at-arr", TIM3->CNT, 3);
    check_equal("counts-down", timer_trail(TIM3, 6), 0x210321);
    check_equal("underflow-sets-uif", updated(), 1);

    fresh(3, 1u << TIM_CR1_CMS_SHIFT);
    check_equal("counts-up-and-down", timer_trail(TIM3, 8), 0x12321012);
    uint32_t updates = 0, downs = 0;
    updated();
    for (int i = 0; i < 12; ++i) {
        timer_step();
        updates += updated();
        downs += (TIM3->CR1 & TIM_CR1_DIR) != 0;
    }
    check_equal("two-updates-a-period", updates, 4);
    check_equal("down-half-the-time", downs, 6);

    fresh(3, 0);
    TIM3->PSC = 2; // takes effect with the next update
    check_equal("psc-is-preloaded", timer_trail(TIM3, 4), 0x1230);
    check_equal("psc-divides-by-3", timer_trail(TIM3, 7), 0x0011122);
    timers_reset();
    TIM3->ARR = 0;
    TIM3->CR1 = TIM_CR1_CEN;
    timer_settle();
    check_equal("arr-0-blocks", TIM3->CNT, 0);
}

static void preloading(void)
{
    fresh(3, 0);
    TIM3->ARR = 1;
    check_equal("arr-at-once", timer_trail(TIM3, 3), 0x101);
    fresh(3, TIM_CR1_ARPE);
    TIM3->ARR = 1;
    check_equal("arr-preloaded", timer_trail(TIM3, 7), 0x1230101);
    check_equal("arr-reads-preload", TIM3->ARR, 1);

    fresh(3, TIM_CR1_UDIS);
    TIM3->SR = 0;
    timer_steps(5);
    check_equal("udis-no-uif", updated(), 0);
    check_equal("udis-still-wraps", TIM3->CNT, 1);
    fresh(3, TIM_CR1_URS);
    TIM3->EGR = TIM_EGR_UG;
    timer_settle();
    check_equal("urs-no-uif-by-ug", updated(), 0);
    timer_steps(4);
    check_equal("urs-uif-by-overflow", updated(), 1);

    fresh(3, 0);
    TIM3->PSC = 3;
    timer_load(TIM3);
    timer_steps(3);
    TIM3->EGR = TIM_EGR_UG; // also empties the prescaler
    timer_settle();
    check_equal("ug-restarts-prescaler", timer_trail(TIM3, 4), 0x0001);

    fresh(3, TIM_CR1_OPM);
    timer_steps(4);
    check_equal("one-pulse-clears-cen", TIM3->CR1 & TIM_CR1_CEN, 0);
    timer_steps(2);
    check_equal("one-pulse-stops", TIM3->CNT, 0);
}

// --- Compare (15.3.8, 15.3.9): levels at the pin, count by count, as bits; the first is the highest

static void compare_channel(uint32_t mode, uint32_t ccr)
{
    TIM3->CCMR1 = mode;
    TIM3->CCR[0] = ccr;
    TIM3->CCER = TIM_CCER_E(1);
    timer_load(TIM3);
    TIM3->CR1 |= TIM_CR1_CEN;
    timer_settle();
}

static uint32_t levels(uint32_t count)
{
    uint32_t trail = pin_read(GPIOA, 6);
    while (--count) {
        timer_step();
        trail = trail << 1 | pin_read(GPIOA, 6);
    }
    return trail;
}

static uint32_t pwm(uint32_t mode, uint32_t ccr)
{
    fresh(3, 0);
    compare_channel(mode, ccr);
    return levels(8);
}

static void compare_modes(void)
{
    check_equal("pwm1", pwm(TIM_OC_PWM1, 1), 0x88);
    check_equal("pwm1-three-quarters", pwm(TIM_OC_PWM1, 3), 0xEE);
    check_equal("pwm1-never", pwm(TIM_OC_PWM1, 0), 0x00);
    check_equal("pwm1-always", pwm(TIM_OC_PWM1, 4), 0xFF);
    check_equal("pwm2", pwm(TIM_OC_PWM2, 1), 0x77);
    check_equal("toggle", pwm(TIM_OC_TOGGLE, 2), 0x3C);
    check_equal("active-on-match", pwm(TIM_OC_ACTIVE, 2), 0x3F);
    check_equal("frozen", pwm(TIM_OC_FROZEN, 2), 0x00);
    check_equal("force-high", pwm(TIM_OC_FORCE_HIGH, 2), 0xFF);
    check_equal("force-low", pwm(TIM_OC_FORCE_LOW, 2), 0x00);

    fresh(3, 0);
    compare_channel(TIM_OC_FORCE_HIGH, 2);
    TIM3->CCMR1 = TIM_OC_INACTIVE;
    check_equal("inactive-on-match", levels(4), 0xC);

    fresh(3, TIM_CR1_DIR);
    compare_channel(TIM_OC_PWM1, 2);
    check_equal("pwm1-down", levels(8), 0x77); // 3 2 1 0: active while CNT <= CCR
    fresh(4, 1u << TIM_CR1_CMS_SHIFT);
    compare_channel(TIM_OC_PWM1, 2);
    check_equal("pwm1-centre", levels(9), 0x187); // 0 1 2 3 4 3 2 1 0

    fresh(3, 0);
    compare_channel(TIM_OC_PWM1, 1);
    TIM3->CCER = TIM_CCER_E(1) | TIM_CCER_P(1);
    timer_load(TIM3);
    check_equal("polarity-inverts", levels(8), 0x77);
}

static void compare_preload(void)
{
    fresh(3, 0);
    compare_channel(TIM_OC_PWM1, 1);
    TIM3->CCR[0] = 3;
    check_equal("ccr-at-once", levels(8), 0xEE);
    fresh(3, 0);
    compare_channel(TIM_OC_PWM1 | TIM_OC_PRELOAD, 1);
    TIM3->CCR[0] = 3;
    check_equal("ccr-preloaded", levels(8), 0x8E);
}

static void compare_flags(void)
{
    fresh(3, 0);
    TIM3->CCR[1] = 2;
    timer_load(TIM3);
    timer_step();
    check_equal("no-flag-before-match", TIM3->SR & TIM_CCIF(2), 0);
    timer_step();
    check_equal("flag-at-match", TIM3->SR & TIM_CCIF(2), TIM_CCIF(2));
    TIM3->SR = ~TIM_CCIF(2);
    timer_steps(3);
    check_equal("flag-once-a-period", TIM3->SR & TIM_CCIF(2), 0);
    TIM3->EGR = TIM_CCIF(3);
    timer_settle();
    check_equal("cc3g-sets-flag", TIM3->SR & TIM_CCIF(3), TIM_CCIF(3));

    TIM3->SR = 0;
    irq_unpend(TIM3_IRQ);
    TIM3->DIER = TIM_CCIF(2);
    check("no-interrupt-yet", !irq_is_pending(TIM3_IRQ));
    timer_steps(4);
    check("cc2ie-requests-interrupt", irq_is_pending(TIM3_IRQ));
    TIM3->SR = 0;
    irq_unpend(TIM3_IRQ);
    TIM3->DIER = TIM_UIF;
    check("interrupt-gone-with-flag", !irq_is_pending(TIM3_IRQ));
    timer_steps(4);
    check("uie-requests-interrupt", irq_is_pending(TIM3_IRQ));
    TIM3->DIER = 0;
    irq_unpend(TIM3_IRQ);
}

// --- Time: counting HCLK, which TIM3 gets here (36 MHz on APB1, doubled)

static uint32_t cycles_of_periods(uint32_t psc, uint32_t arr, uint32_t cr1, uint32_t periods)
{
    timers_reset();
    TIM3->PSC = psc;
    TIM3->ARR = arr;
    TIM3->CR1 = cr1;
    timer_load(TIM3);
    TIM3->CR1 = cr1 | TIM_CR1_CEN;
    wait_until(TIM3->SR & TIM_UIF);
    uint32_t begin = cycles();
    while (periods--) {
        TIM3->SR = 0;
        wait_until(TIM3->SR & TIM_UIF);
    }
    return cycles() - begin;
}

static void periods(void)
{
    check_range("period-is-arr-plus-1", cycles_of_periods(0, 1999, 0, 10), 20000 - POLL, 20000 + POLL);
    check_range("prescaler-is-psc-plus-1", cycles_of_periods(6, 299, 0, 10), 21000 - POLL, 21000 + POLL);
    check_range("down-is-as-long", cycles_of_periods(0, 1999, TIM_CR1_DIR, 10), 20000 - POLL, 20000 + POLL);
    check_range("centre-updates-each-arr", cycles_of_periods(0, 1000, 1u << TIM_CR1_CMS_SHIFT, 10), 10000 - POLL, 10000 + POLL);
    timers_reset();
    TIM3->CR1 = TIM_CR1_CEN;
    uint32_t begin = cycles();
    wait_cycles(5000);
    uint32_t counted = TIM3->CNT;
    check_range("cnt-follows-hclk", counted - (cycles() - begin) + POLL, 0, 2 * POLL);
}

// Two edges of OC1REF, captured by TIM2 through its trigger input (15.3.14): exact, no instruction is in the way.
static void exact_pwm_period(void)
{
    timers_reset();
    TIM2->SMCR = TIM_TS_ITR(2); // TIM3
    TIM2->CCMR1 = TIM_CC_INPUT_TRC;
    TIM2->CCER = TIM_CCER_E(1);
    TIM2->CR1 = TIM_CR1_CEN;
    TIM3->ARR = 1233;
    TIM3->CCMR1 = TIM_OC_PWM1;
    TIM3->CCR[0] = 400;
    TIM3->CR2 = TIM_TRGO_OC1REF << TIM_CR2_MMS_SHIFT;
    timer_load(TIM3);
    TIM3->CR1 = TIM_CR1_CEN;
    TIM2->SR = 0;
    wait_until(TIM2->SR & TIM_CCIF(1));
    uint32_t first = TIM2->CCR[0];
    wait_until(TIM2->SR & TIM_CCIF(1));
    uint32_t second = TIM2->CCR[0];
    check_equal("pwm-period-is-exact", (second - first) & 0xFFFF, 1234);
}

// --- DMA burst (15.3.15): one update moves three words, to CCR1, CCR2 and CCR3

static void dma_burst(void)
{
    static const uint32_t values[3] = {0x111, 0x222, 0x333};
    fresh(3, 0);
    RCC->AHBENR |= RCC_AHB_DMA1;
    volatile dma_channel_t *channel = DMA1_CHANNEL(DMA_TIM3_UP);
    channel->CPAR = (uint32_t)(uintptr_t)&TIM3->DMAR;
    channel->CMAR = (uint32_t)(uintptr_t)values;
    channel->CNDTR = 3;
    channel->CCR = DMA_CCR_FROM_MEMORY | DMA_CCR_MINC | 2u << DMA_CCR_PSIZE_SHIFT | 2u << DMA_CCR_MSIZE_SHIFT | DMA_CCR_EN;
    TIM3->DCR = (3u - 1u) << 8 | __builtin_offsetof(tim_t, CCR) / 4;
    TIM3->DIER = TIM_DIER_UDE;
    timer_steps(4);
    wait_cycles(100);
    check_equal("burst-first", TIM3->CCR[0], 0x111);
    check_equal("burst-second", TIM3->CCR[1], 0x222);
    check_equal("burst-third", TIM3->CCR[2], 0x333);
    channel->CCR = 0;
}

int main(void)
{
    clock_72mhz();
    cycles_start();
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOA;
    pin_mode(GPIOA, 6, PIN_ALTERNATE);
    registers();
    counting();
    preloading();
    compare_modes();
    compare_preload();
    compare_flags();
    periods();
    exact_pwm_period();
    dma_burst();
    check_done();
}
