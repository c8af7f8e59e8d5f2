// SPDX-License-Identifier: GPL-2.0-or-later
//
// Both timers count the same steps, so that the same throttle is the same duty on both sides.
//
// PE10 is the complementary output of TIM1's channel 2. With CC2NE alone it is not complemented: it follows OC2REF, as
// a plain output would (RM0410, table 168, CC2E = 0).

#include "rover/board/motors.h"

#include <stdbool.h>

#include "rover/board/clock.h"
#include "rover/chip/gpio.h"
#include "rover/chip/rcc.h"
#include "rover/chip/tim.h"
#include "rover/options.h"

#define AF_TIM 1u // of TIM1 and TIM2 (DS11532, table 12)
#define STEPS 18000u // in a period; 50 Hz and 1 kHz both come out even
#define COUNT_HZ (STEPS * PWM_HZ)

_Static_assert(TIMERS1_HZ % COUNT_HZ == 0 && TIMERS2_HZ % COUNT_HZ == 0, "PWM_HZ does not divide the timers' clocks");

struct bridge {
    char forward_port, backward_port;
    uint8_t forward_pin, backward_pin;
};

static const struct bridge BRIDGES[SIDES] = {
    [LEFT] = {'B', 'E', 10, 15},
    [RIGHT] = {'E', 'E', 14, 12},
};

static void set_direction(const struct bridge *bridge, bool forward)
{
    pin_write(GPIO(bridge->forward_port), bridge->forward_pin, forward);
    pin_write(GPIO(bridge->backward_port), bridge->backward_pin, !forward);
}

static void start_timer(volatile tim_t *timer, uint32_t clock_hz)
{
    timer->PSC = clock_hz / COUNT_HZ - 1;
    timer->ARR = STEPS - 1;
    timer->EGR = TIM_EGR_UG;
    timer->CR1 = TIM_CR1_ARPE | TIM_CR1_CEN;
}

void motors_start(void)
{
    RCC->AHB1ENR |= RCC_AHB1_GPIO('B') | RCC_AHB1_GPIO('E');
    RCC->APB1ENR |= RCC_APB1_TIM2;
    RCC->APB2ENR |= RCC_APB2_TIM1;
    for (unsigned side = LEFT; side < SIDES; ++side) {
        const struct bridge *bridge = &BRIDGES[side];
        set_direction(bridge, true);
        pin_mode(GPIO(bridge->forward_port), bridge->forward_pin, PIN_OUTPUT);
        pin_mode(GPIO(bridge->backward_port), bridge->backward_pin, PIN_OUTPUT);
    }
    TIM2->CCMR[1] = (TIM_OC_PWM1 | TIM_OC_PRELOAD) << 8; // channel 4
    TIM2->CCER = TIM_CCER_E(4);
    TIM1->CCMR[0] = (TIM_OC_PWM1 | TIM_OC_PRELOAD) << 8; // channel 2
    TIM1->CCER = TIM_CCER_NE(2);
    TIM1->BDTR = TIM_BDTR_MOE;
    start_timer(TIM2, TIMERS1_HZ);
    start_timer(TIM1, TIMERS2_HZ);
    pin_alternate(GPIO('B'), 11, AF_TIM);
    pin_alternate(GPIO('E'), 10, AF_TIM);
}

// A compare value of STEPS is never reached: the output stays high.
static uint32_t steps_of(float throttle)
{
    float size = throttle < 0.0f ? -throttle : throttle;
    if (!(size < 1.0f))
        return size >= 1.0f ? STEPS : 0; // NaN is neither
    return (uint32_t)(size * (float)STEPS + 0.5f);
}

void motors_put(enum side side, float throttle)
{
    set_direction(&BRIDGES[side], !(throttle < 0.0f));
    if (side == LEFT)
        TIM2->CCR[3] = steps_of(throttle);
    else
        TIM1->CCR[1] = steps_of(throttle);
}
