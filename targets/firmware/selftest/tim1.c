// SPDX-License-Identifier: GPL-2.0-or-later
//
// What only the advanced timer has (RM0008, section 14): main output enable, complementary outputs, dead time, break, lock,
// repetition, commutation. TIM1_CH1 PA8, TIM1_CH1N PB13 and TIM1_BKIN PB12, with nothing attached.

#include "check.h"
#include "chip/stm32f103.h"
#include "clock.h"
#include "pin.h"
#include "timer.h"
#include "wait.h"

#define LATE 60 // cycles that a polling loop and what is around it may be late

enum { MAIN = 8, COMPLEMENT = 13, BREAK = 12 };

#define BOTH (TIM_CCER_E(1) | TIM_CCER_NE(1))

static uint32_t main_out(void) { return pin_read(GPIOA, MAIN); }
static uint32_t complement_out(void) { return pin_read(GPIOB, COMPLEMENT); }

// Both levels as two digits: 0x10 is the main output high and the complement low.
static uint32_t outputs(void)
{
    timer_settle();
    return main_out() << 4 | complement_out();
}

static void fresh(void)
{
    timers_reset();
    pin_pull(GPIOB, BREAK, true);
    pin_mode(GPIOA, MAIN, PIN_ALTERNATE);
    pin_mode(GPIOB, COMPLEMENT, PIN_ALTERNATE);
    irq_unpend(TIM1_BRK_IRQ);
    irq_unpend(TIM1_UP_IRQ);
    irq_unpend(TIM1_TRG_COM_IRQ);
    irq_unpend(TIM1_CC_IRQ);
}

// Counts 0 to 3 by steps, PWM 1, high for the first two of the four.
static void fresh_pwm(uint32_t ccer, uint32_t bdtr)
{
    fresh();
    timer_clock_by_steps(TIM1);
    TIM1->ARR = 3;
    TIM1->CCR[0] = 2;
    TIM1->CCMR1 = TIM_OC_PWM1;
    TIM1->CCER = ccer;
    TIM1->BDTR = bdtr;
    timer_load(TIM1);
    TIM1->CR1 = TIM_CR1_CEN;
    timer_settle();
}

static uint32_t trail(uint32_t (*level)(void), uint32_t count)
{
    uint32_t bits = level();
    while (--count) {
        timer_step();
        bits = bits << 1 | level();
    }
    return bits;
}

// --- Outputs (14.3.12; table 83)

static void output_control(void)
{
    fresh();
    check_equal("bdtr-reset", TIM1->BDTR, 0);
    fresh_pwm(BOTH, TIM_BDTR_MOE);
    check_equal("main-output", trail(main_out, 8), 0xCC);
    fresh_pwm(BOTH, TIM_BDTR_MOE);
    check_equal("complementary-output", trail(complement_out, 8), 0x33);
    fresh_pwm(TIM_CCER_NE(1), TIM_BDTR_MOE);
    check_equal("complement-alone-is-not-inverted", trail(complement_out, 8), 0xCC);
    fresh_pwm(BOTH | TIM_CCER_P(1) | TIM_CCER_NP(1), TIM_BDTR_MOE);
    check_equal("main-inverted", trail(main_out, 8), 0x33);
    fresh_pwm(BOTH | TIM_CCER_P(1) | TIM_CCER_NP(1), TIM_BDTR_MOE);
    check_equal("complement-inverted", trail(complement_out, 8), 0xCC);
    fresh_pwm(TIM_CCER_E(1), TIM_BDTR_MOE | TIM_BDTR_OSSR);
    check_equal("ossr-holds-complement-off", trail(complement_out, 8), 0x00);
    fresh_pwm(TIM_CCER_E(1) | TIM_CCER_NP(1), TIM_BDTR_MOE | TIM_BDTR_OSSR);
    check_equal("ossr-off-is-polarity", trail(complement_out, 8), 0xFF);
}

static void idle_levels(void)
{
    fresh_pwm(BOTH, TIM_BDTR_OSSI);
    check_equal("idle-levels-low", outputs(), 0x00);
    TIM1->CR2 = TIM_CR2_OIS1;
    check_equal("idle-level-of-main", outputs(), 0x10);
    TIM1->CR2 = TIM_CR2_OIS1N;
    check_equal("idle-level-of-complement", outputs(), 0x01);
    TIM1->BDTR |= TIM_BDTR_MOE;
    check_equal("moe-ends-idle", outputs(), 0x10);
}

// --- Dead time (14.3.11): after either edge both outputs are off for it

static void dead_time(const char *name, uint32_t dtg, uint32_t ckd, uint32_t want)
{
    fresh();
    TIM1->ARR = 7999;
    TIM1->CCR[0] = 4000;
    TIM1->CCMR1 = TIM_OC_PWM1;
    TIM1->CCER = BOTH;
    TIM1->CR1 = ckd << TIM_CR1_CKD_SHIFT;
    TIM1->BDTR = TIM_BDTR_MOE | dtg;
    timer_load(TIM1);
    TIM1->CR1 |= TIM_CR1_CEN;
    wait_until(main_out());
    wait_until(!main_out());
    uint32_t start = cycles();
    wait_until(complement_out());
    uint32_t falling = cycles() - start;
    wait_until(!complement_out());
    start = cycles();
    wait_until(main_out());
    uint32_t rising = cycles() - start;
    check_range(name, falling, want - LATE, want + LATE);
    check_range(name, rising, want - LATE, want + LATE);
}

static void dead_times(void)
{
    dead_time("dead-time-100", 100, 0, 100);
    dead_time("dead-time-148", 0x80 | 10, 0, 148);
    dead_time("dead-time-296", 0xC0 | 5, 0, 296);
    dead_time("dead-time-1008", 0xFF, 0, 1008);
    dead_time("dead-time-of-slow-dts", 100, 2, 400);
}

// --- Break (14.3.12): the input acts as long as it is at its level

static void breaking(void)
{
    fresh_pwm(BOTH, TIM_BDTR_MOE | TIM_BDTR_OSSI);
    TIM1->DIER = TIM_BIF;
    TIM1->EGR = TIM_EGR_BG;
    timer_settle();
    check_equal("bg-clears-moe", TIM1->BDTR & TIM_BDTR_MOE, 0);
    check_equal("bg-sets-bif", TIM1->SR & TIM_BIF, TIM_BIF);
    check("bie-requests-break-interrupt", irq_is_pending(TIM1_BRK_IRQ));
    check_equal("break-idles-outputs", outputs(), 0x00);
    TIM1->SR = 0;
    TIM1->BDTR |= TIM_BDTR_MOE;
    check_equal("moe-by-software", TIM1->BDTR & TIM_BDTR_MOE, TIM_BDTR_MOE);

    fresh_pwm(BOTH, TIM_BDTR_BKE); // active low; the pin is pulled up
    timer_settle();
    TIM1->BDTR |= TIM_BDTR_MOE;
    TIM1->SR = 0;
    check_equal("no-break-yet", TIM1->BDTR & TIM_BDTR_MOE, TIM_BDTR_MOE);
    pin_write(GPIOB, BREAK, false);
    wait_cycles(50);
    check_equal("pin-clears-moe", TIM1->BDTR & TIM_BDTR_MOE, 0);
    check_equal("pin-sets-bif", TIM1->SR & TIM_BIF, TIM_BIF);
    TIM1->SR = 0;
    timer_settle();
    check_equal("bif-stays-while-pin-acts", TIM1->SR & TIM_BIF, TIM_BIF);
    TIM1->BDTR |= TIM_BDTR_MOE;
    timer_settle();
    check_equal("no-moe-while-pin-acts", TIM1->BDTR & TIM_BDTR_MOE, 0);
    pin_write(GPIOB, BREAK, true);
    wait_cycles(50);
    TIM1->SR = 0;
    check_equal("bif-clears-afterwards", TIM1->SR & TIM_BIF, 0);
    timer_steps(5);
    check_equal("moe-stays-off-without-aoe", TIM1->BDTR & TIM_BDTR_MOE, 0);
    TIM1->BDTR |= TIM_BDTR_AOE;
    timer_steps(5);
    check_equal("aoe-sets-moe-with-update", TIM1->BDTR & TIM_BDTR_MOE, TIM_BDTR_MOE);

    fresh_pwm(BOTH, TIM_BDTR_BKP); // active high and off while not enabled
    timer_settle();
    TIM1->BDTR |= TIM_BDTR_MOE;
    wait_cycles(50);
    check_equal("no-break-without-bke", TIM1->BDTR & TIM_BDTR_MOE, TIM_BDTR_MOE);
    TIM1->BDTR |= TIM_BDTR_BKE;
    wait_cycles(50);
    check_equal("break-active-high", TIM1->BDTR & TIM_BDTR_MOE, 0);
}

// --- Lock (14.4.18): what is locked keeps its value until the next reset, the level itself too

static void locking(void)
{
    fresh_pwm(BOTH, 1u << TIM_BDTR_LOCK_SHIFT | 0x10);
    TIM1->BDTR = TIM_BDTR_MOE | TIM_BDTR_BKE | TIM_BDTR_OSSI | 0x20;
    uint32_t want = 1u << TIM_BDTR_LOCK_SHIFT | TIM_BDTR_MOE | TIM_BDTR_OSSI | 0x10;
    check_equal("lock-1-fixes-break-and-dead-time", TIM1->BDTR, want);
    TIM1->CR2 = TIM_CR2_OIS1;
    check_equal("lock-1-fixes-idle-levels", TIM1->CR2, 0);
    TIM1->CCER = BOTH | TIM_CCER_P(1);
    check_equal("lock-1-leaves-polarity", TIM1->CCER, BOTH | TIM_CCER_P(1));

    fresh_pwm(BOTH, 2u << TIM_BDTR_LOCK_SHIFT);
    TIM1->CCER = BOTH | TIM_CCER_P(1) | TIM_CCER_NP(1);
    check_equal("lock-2-fixes-polarity", TIM1->CCER, BOTH);
    TIM1->BDTR = TIM_BDTR_OSSI | TIM_BDTR_OSSR;
    check_equal("lock-2-fixes-off-states", TIM1->BDTR, 2u << TIM_BDTR_LOCK_SHIFT);
    TIM1->CCMR1 = TIM_OC_PWM2;
    check_equal("lock-2-leaves-mode", TIM1->CCMR1, TIM_OC_PWM2);

    fresh_pwm(BOTH, 3u << TIM_BDTR_LOCK_SHIFT);
    TIM1->CCMR1 = TIM_OC_PWM2;
    check_equal("lock-3-fixes-mode", TIM1->CCMR1, TIM_OC_PWM1);
}

// --- Repetition (14.3.3): an update event for each RCR + 1 overflows

static uint32_t updates_in(uint32_t steps)
{
    uint32_t updates = 0;
    TIM1->SR = 0;
    while (steps--) {
        timer_step();
        updates += TIM1->SR & TIM_UIF;
        TIM1->SR = ~TIM_UIF;
    }
    return updates;
}

static void repetition(void)
{
    fresh_pwm(0, 0);
    check_equal("each-overflow-updates", updates_in(24), 6);
    TIM1->RCR = 2;
    timer_load(TIM1);
    check_equal("each-third-overflow-updates", updates_in(24), 2);
    TIM1->RCR = 0;
    check_equal("rcr-is-preloaded", updates_in(8), 0); // two overflows of the next three
    check_equal("rcr-loaded-by-update", updates_in(12), 3);
    irq_unpend(TIM1_UP_IRQ);
    TIM1->DIER = TIM_UIF;
    timer_steps(4);
    check("uie-requests-update-interrupt", irq_is_pending(TIM1_UP_IRQ));
    TIM1->SR = 0;
    TIM1->DIER = TIM_CCIF(1);
    timer_steps(4);
    check("cc1ie-requests-compare-interrupt", irq_is_pending(TIM1_CC_IRQ));
}

// --- Commutation (14.3.14): with CCPC, mode and enables wait for COM

static void commutation(void)
{
    fresh_pwm(BOTH, TIM_BDTR_MOE);
    TIM1->CR2 = TIM_CR2_CCPC;
    TIM1->CCMR1 = TIM_OC_FORCE_LOW;
    check_equal("mode-waits-for-com", outputs(), 0x10);
    TIM1->DIER = TIM_COMIF;
    TIM1->EGR = TIM_EGR_COMG;
    timer_settle();
    check_equal("com-changes-mode", outputs(), 0x01);
    check_equal("com-sets-comif", TIM1->SR & TIM_COMIF, TIM_COMIF);
    check("comie-requests-interrupt", irq_is_pending(TIM1_TRG_COM_IRQ));
}

int main(void)
{
    clock_72mhz();
    cycles_start();
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOA | RCC_APB2_GPIOB;
    output_control();
    idle_levels();
    dead_times();
    breaking();
    locking();
    repetition();
    commutation();
    check_done();
}
