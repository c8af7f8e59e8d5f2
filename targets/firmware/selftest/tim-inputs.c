// SPDX-License-Identifier: GPL-2.0-or-later
//
// The inputs of the general-purpose timers (RM0008, 15.3.3 to 15.3.7, 15.3.10 to 15.3.14): capture, encoder, external
// clocks, slave modes, one-pulse mode. Edges come from switching the pulls of the input pins: TIM3_CH1 PA6, TIM3_CH2 PA7,
// TIM2_ETR PA0. Nothing may be attached to these.

#include "check.h"
#include "chip/stm32f103.h"
#include "clock.h"
#include "pin.h"
#include "timer.h"
#include "wait.h"

#define LATE 80 // cycles from the write that moves a pull to the counter having noticed, with what is around it

enum { ETR = 0, CH1 = 6, CH2 = 7 };

static void fresh(void)
{
    timers_reset();
    pin_pull(GPIOA, ETR, false);
    pin_pull(GPIOA, CH1, false);
    pin_pull(GPIOA, CH2, false);
    timer_settle();
}

static void set_pin(unsigned pin, bool up)
{
    pin_write(GPIOA, pin, up);
    wait_cycles(50); // the pull has some picofarads to charge, the timer two stages to pass
}

// --- Input capture (15.3.5, 15.3.6)

static void capture_at(const char *name, bool up, bool expected)
{
    TIM3->SR = 0;
    uint32_t before = TIM3->CNT;
    set_pin(CH1, up);
    bool captured = TIM3->SR & TIM_CCIF(1);
    if (captured != expected || !expected)
        check_equal(name, captured, expected);
    else
        check_range(name, (TIM3->CCR[0] - before) & 0xFFFF, 0, LATE);
}

static void capture(void)
{
    fresh();
    TIM3->CCMR1 = TIM_CC_INPUT_DIRECT;
    TIM3->CCER = TIM_CCER_E(1);
    TIM3->CR1 = TIM_CR1_CEN;
    capture_at("captures-rising", true, true);
    capture_at("ignores-falling", false, false);
    TIM3->CCER = TIM_CCER_E(1) | TIM_CCER_P(1);
    set_pin(CH1, true);
    capture_at("captures-falling", false, true);
    capture_at("ignores-rising", true, false);

    TIM3->CCER = TIM_CCER_E(1);
    set_pin(CH1, false);
    TIM3->SR = 0;
    set_pin(CH1, true);
    check_equal("no-overcapture-yet", TIM3->SR & TIM_CCOF(1), 0);
    set_pin(CH1, false);
    set_pin(CH1, true);
    check_equal("overcapture", TIM3->SR & TIM_CCOF(1), TIM_CCOF(1));
    (void)TIM3->CCR[0];
    check_equal("reading-ccr-clears-flag", TIM3->SR & TIM_CCIF(1), 0);
    check_equal("reading-ccr-keeps-overcapture", TIM3->SR & TIM_CCOF(1), TIM_CCOF(1));
    TIM3->CNT = 4321;
    TIM3->EGR = TIM_CCIF(1);
    timer_settle();
    check_range("cc1g-captures", TIM3->CCR[0], 4321, 4321 + LATE);
    uint32_t kept = TIM3->CCR[0];
    TIM3->CCR[0] = 7;
    check_equal("ccr-of-input-is-read-only", TIM3->CCR[0], kept);

    fresh();
    TIM3->CCMR1 = TIM_CC_INPUT_DIRECT | 2u << TIM_IC_PSC_SHIFT; // each fourth edge
    TIM3->CCER = TIM_CCER_E(1);
    TIM3->CR1 = TIM_CR1_CEN;
    uint32_t captures = 0;
    for (int i = 0; i < 12; ++i) {
        set_pin(CH1, true);
        captures += (TIM3->SR & TIM_CCIF(1)) != 0;
        TIM3->SR = 0;
        set_pin(CH1, false);
    }
    check_equal("prescaled-captures", captures, 3);
}

static void filter(void)
{
    fresh();
    TIM3->CCMR1 = TIM_CC_INPUT_DIRECT | 15u << TIM_IC_FILTER_SHIFT; // eight samples, one each 32 cycles
    TIM3->CCER = TIM_CCER_E(1);
    TIM3->CR1 = TIM_CR1_CEN;
    timer_settle();
    pin_write(GPIOA, CH1, true);
    wait_cycles(100);
    pin_write(GPIOA, CH1, false);
    wait_cycles(500);
    check_equal("filter-drops-glitch", TIM3->SR & TIM_CCIF(1), 0);
    uint32_t before = TIM3->CNT;
    pin_write(GPIOA, CH1, true);
    check("filter-lets-level", wait_until(TIM3->SR & TIM_CCIF(1)));
    check_range("filter-delays", (TIM3->CCR[0] - before) & 0xFFFF, 7 * 32, 9 * 32 + LATE);
}

// PWM input mode (15.3.6): one input, both edges, the rising one resetting the counter
static void pwm_input(void)
{
    fresh();
    TIM3->CCMR1 = TIM_CC_INPUT_DIRECT | TIM_CC_INPUT_OTHER << 8;
    TIM3->CCER = TIM_CCER_E(1) | TIM_CCER_E(2) | TIM_CCER_P(2);
    TIM3->SMCR = TIM_TS_TI1FP1 | TIM_SLAVE_RESET;
    TIM3->CR1 = TIM_CR1_CEN;
    uint32_t at = cycles();
    for (int i = 0; i < 3; ++i) {
        pin_write(GPIOA, CH1, true);
        at = wait_cycles_from(at, 1500);
        pin_write(GPIOA, CH1, false);
        at = wait_cycles_from(at, 3500);
    }
    check_range("pwm-input-period", TIM3->CCR[0], 5000 - LATE, 5000 + LATE);
    check_range("pwm-input-width", TIM3->CCR[1], 1500 - LATE, 1500 + LATE);
    check_equal("trigger-flag", TIM3->SR & TIM_TIF, TIM_TIF);
}

// --- Encoder (15.3.12): a quarter turn is one edge of one of the two inputs

static void quarter_turns(int count)
{
    static const uint8_t gray[4] = {0, 1, 3, 2}; // CH1 leads when it turns forward
    static unsigned phase;
    if (count == 0)
        phase = 0;
    while (count) {
        phase += count > 0 ? 1u : 3u;
        count += count > 0 ? -1 : 1;
        uint32_t level = gray[phase % 4];
        pin_write(GPIOA, CH1, level & 1);
        pin_write(GPIOA, CH2, level >> 1 & 1);
        wait_cycles(50);
    }
}

static void encoder_mode(uint32_t mode, uint32_t ccer)
{
    fresh();
    quarter_turns(0);
    TIM3->CCMR1 = TIM_CC_INPUT_DIRECT | TIM_CC_INPUT_DIRECT << 8;
    TIM3->CCER = ccer;
    TIM3->SMCR = mode;
    TIM3->CNT = 100;
    TIM3->CR1 = TIM_CR1_CEN;
    timer_settle();
}

static void encoder(void)
{
    encoder_mode(TIM_SLAVE_ENCODER3, 0);
    quarter_turns(10);
    check_equal("encoder3-forward", TIM3->CNT, 110);
    check_equal("encoder3-dir-up", TIM3->CR1 & TIM_CR1_DIR, 0);
    quarter_turns(-13);
    check_equal("encoder3-backward", TIM3->CNT, 97);
    check_equal("encoder3-dir-down", TIM3->CR1 & TIM_CR1_DIR, TIM_CR1_DIR);
    encoder_mode(TIM_SLAVE_ENCODER1, 0);
    quarter_turns(8);
    check_equal("encoder1-counts-ti2-edges", TIM3->CNT, 104);
    encoder_mode(TIM_SLAVE_ENCODER2, 0);
    quarter_turns(8);
    check_equal("encoder2-counts-ti1-edges", TIM3->CNT, 104);
    quarter_turns(-4);
    check_equal("encoder2-backward", TIM3->CNT, 102);
    encoder_mode(TIM_SLAVE_ENCODER3, TIM_CCER_P(1));
    quarter_turns(6);
    check_equal("encoder-inverted-input", TIM3->CNT, 94);
    encoder_mode(TIM_SLAVE_ENCODER3, 0);
    TIM3->ARR = 103;
    TIM3->SR = 0;
    quarter_turns(5);
    check_equal("encoder-wraps-up", TIM3->CNT, 1);
    check_equal("encoder-wrap-sets-uif", TIM3->SR & TIM_UIF, TIM_UIF);
    quarter_turns(-3);
    check_equal("encoder-wraps-down", TIM3->CNT, 102);
    quarter_turns(1);
    quarter_turns(-1);
    quarter_turns(1);
    check_equal("encoder-jitter-stays", TIM3->CNT, 103);
}

// --- External clocks (15.3.3)

static void external_clocks(void)
{
    fresh();
    TIM3->CCMR1 = TIM_CC_INPUT_DIRECT;
    TIM3->SMCR = TIM_TS_TI1FP1 | TIM_SLAVE_EXTERNAL;
    TIM3->CR1 = TIM_CR1_CEN;
    timer_settle();
    TIM3->CNT = 0;
    for (int i = 0; i < 5; ++i) {
        set_pin(CH1, true);
        set_pin(CH1, false);
    }
    check_equal("external-clock-ti1fp1", TIM3->CNT, 5);

    fresh();
    TIM3->CCMR1 = TIM_CC_INPUT_DIRECT;
    TIM3->SMCR = TIM_TS_TI1F_ED | TIM_SLAVE_EXTERNAL;
    TIM3->CR1 = TIM_CR1_CEN;
    timer_settle();
    TIM3->CNT = 0;
    for (int i = 0; i < 5; ++i) {
        set_pin(CH1, true);
        set_pin(CH1, false);
    }
    check_equal("external-clock-both-edges", TIM3->CNT, 10);

    fresh();
    TIM2->SMCR = TIM_SMCR_ECE;
    TIM2->CR1 = TIM_CR1_CEN;
    for (int i = 0; i < 5; ++i) {
        set_pin(ETR, true);
        set_pin(ETR, false);
    }
    check_equal("external-clock-etr", TIM2->CNT, 5);
    TIM2->SMCR = TIM_SMCR_ECE | 1u << 12; // each second edge
    TIM2->CNT = 0;
    for (int i = 0; i < 8; ++i) {
        set_pin(ETR, true);
        set_pin(ETR, false);
    }
    check_equal("etr-prescaled", TIM2->CNT, 4);
}

// --- Slave modes (15.3.13, 15.3.14), with TIM2 as the master and then with a pin

static void slave_modes(void)
{
    fresh();
    TIM3->SMCR = TIM_TS_ITR(1) | TIM_SLAVE_RESET;
    TIM3->CR1 = TIM_CR1_CEN;
    wait_cycles(1000);
    TIM3->SR = 0;
    TIM2->EGR = TIM_EGR_UG;
    timer_settle();
    check_range("slave-reset", TIM3->CNT, 0, LATE);
    check_equal("slave-reset-sets-uif-and-tif", TIM3->SR & (TIM_UIF | TIM_TIF), TIM_UIF | TIM_TIF);

    fresh();
    TIM2->CR2 = TIM_TRGO_ENABLE << TIM_CR2_MMS_SHIFT;
    TIM3->SMCR = TIM_TS_ITR(1) | TIM_SLAVE_GATED;
    TIM3->CR1 = TIM_CR1_CEN;
    wait_cycles(200);
    check_equal("gate-closed", TIM3->CNT, 0);
    TIM2->CR1 = TIM_CR1_CEN;
    wait_cycles(500);
    uint32_t opened = TIM3->SR & TIM_TIF;
    TIM3->SR = 0;
    TIM2->CR1 = 0;
    timer_settle();
    uint32_t counted = TIM3->CNT;
    check_range("gate-open", counted, 500 - LATE, 500 + LATE);
    wait_cycles(200);
    check_equal("gate-closed-again", TIM3->CNT, counted);
    check_equal("gate-keeps-cen", TIM3->CR1 & TIM_CR1_CEN, TIM_CR1_CEN);
    check_equal("gate-opening-sets-tif", opened, TIM_TIF);
    check_equal("gate-closing-sets-tif", TIM3->SR & TIM_TIF, TIM_TIF);

    fresh();
    TIM3->CCMR1 = TIM_CC_INPUT_DIRECT << 8;
    TIM3->SMCR = TIM_TS_TI2FP2 | TIM_SLAVE_TRIGGER;
    wait_cycles(100);
    check_equal("trigger-waits", TIM3->CR1 & TIM_CR1_CEN, 0);
    set_pin(CH2, true);
    uint32_t since = TIM3->CNT;
    check_equal("trigger-starts", TIM3->CR1 & TIM_CR1_CEN, TIM_CR1_CEN);
    check_range("trigger-counts", since, 1, 50 + LATE);

    // A chain: TIM2's update clocks TIM3, two timers as one of 32 bits (15.3.14)
    fresh();
    TIM2->CR2 = TIM_TRGO_UPDATE << TIM_CR2_MMS_SHIFT;
    TIM2->ARR = 99;
    timer_load(TIM2);
    TIM3->SMCR = TIM_TS_ITR(1) | TIM_SLAVE_EXTERNAL;
    TIM3->CR1 = TIM_CR1_CEN;
    TIM3->CNT = 0;
    TIM2->CR1 = TIM_CR1_CEN;
    wait_cycles(5050);
    TIM2->CR1 = 0;
    timer_settle();
    check_range("chained-timers", TIM3->CNT * 100 + TIM2->CNT, 5050 - LATE, 5050 + LATE);
    TIM3->SR = 0;
    TIM3->EGR = TIM_EGR_TG;
    timer_settle();
    check_equal("tg-sets-tif", TIM3->SR & TIM_TIF, TIM_TIF);
}

// --- One pulse (15.3.10): an edge on TI2 makes a pulse on OC1, which is then high for CNT in CCR1 .. ARR

static void one_pulse(void)
{
    fresh();
    pin_mode(GPIOA, CH1, PIN_ALTERNATE);
    TIM3->CCMR1 = TIM_OC_PWM2 | TIM_CC_INPUT_DIRECT << 8;
    TIM3->CCR[0] = 600;
    TIM3->ARR = 1599;
    TIM3->CCER = TIM_CCER_E(1);
    timer_load(TIM3);
    TIM3->SMCR = TIM_TS_TI2FP2 | TIM_SLAVE_TRIGGER;
    TIM3->CR1 = TIM_CR1_OPM;
    timer_settle();
    check("low-before-pulse", !pin_read(GPIOA, CH1));
    uint32_t start = cycles();
    pin_write(GPIOA, CH2, true);
    bool rises = wait_until(pin_read(GPIOA, CH1));
    uint32_t rose = cycles();
    wait_until(!pin_read(GPIOA, CH1));
    uint32_t fell = cycles();
    check("pulse-rises", rises);
    check_range("pulse-delay", rose - start, 600, 600 + 2 * LATE);
    check_range("pulse-width", fell - rose, 1000 - LATE, 1000 + LATE);
    check_equal("pulse-clears-cen", TIM3->CR1 & TIM_CR1_CEN, 0);
    check_equal("pulse-stops-counter", TIM3->CNT, 0);
    pin_write(GPIOA, CH2, false);
    wait_cycles(3000);
    check("no-pulse-by-the-other-edge", !pin_read(GPIOA, CH1) && TIM3->CNT == 0);
    pin_mode(GPIOA, CH1, PIN_PULLED);
}

// --- A compare output cleared by ETR (15.3.11)

static void cleared_by_etr(void)
{
    fresh();
    pin_mode(GPIOA, 1, PIN_ALTERNATE);
    TIM2->CCMR1 = (TIM_OC_PWM1 | 1u << 7) << 8; // OC2CE
    TIM2->CCR[1] = 0xFFFF;
    TIM2->CCER = TIM_CCER_E(2);
    timer_load(TIM2);
    check("ocref-high", pin_read(GPIOA, 1));
    set_pin(ETR, true);
    check("etr-clears-ocref", !pin_read(GPIOA, 1));
    set_pin(ETR, false);
    check("ocref-waits-for-update", !pin_read(GPIOA, 1));
    TIM2->EGR = TIM_EGR_UG;
    timer_settle();
    check("update-restores-ocref", pin_read(GPIOA, 1));
    pin_mode(GPIOA, 1, PIN_FLOATING);
}

int main(void)
{
    clock_72mhz();
    cycles_start();
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOA;
    capture();
    filter();
    pwm_input();
    encoder();
    external_clocks();
    slave_modes();
    one_pulse();
    cleared_by_etr();
    check_done();
}
