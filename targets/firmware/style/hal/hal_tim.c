// SPDX-License-Identifier: GPL-2.0-or-later

#include "hal.h"

__attribute__((weak)) void hal_tim_msp_init(hal_tim_t *tim) { (void)tim; }
__attribute__((weak)) void hal_tim_period_elapsed_callback(hal_tim_t *tim) { (void)tim; }

hal_status_t hal_tim_base_init(hal_tim_t *tim)
{
    if (tim->state == HAL_STATE_RESET)
        hal_tim_msp_init(tim);
    tim->state = HAL_STATE_BUSY;
    tim->instance->CR1 = TIM_CR1_ARPE;
    tim->instance->PSC = tim->prescaler;
    tim->instance->ARR = tim->period;
    tim->instance->EGR = TIM_EGR_UG; // loads the prescaler now
    tim->instance->SR = ~TIM_UIF;
    tim->state = HAL_STATE_READY;
    return HAL_OK;
}

hal_status_t hal_tim_base_start_it(hal_tim_t *tim)
{
    if (tim->state != HAL_STATE_READY)
        return HAL_ERROR;
    tim->instance->DIER |= TIM_UIF;
    tim->instance->CR1 |= TIM_CR1_CEN;
    tim->state = HAL_STATE_BUSY;
    return HAL_OK;
}

hal_status_t hal_tim_pwm_start(hal_tim_t *tim, unsigned channel, uint32_t pulse)
{
    if (channel < 1 || channel > 4)
        return HAL_ERROR;
    volatile uint32_t *ccmr = channel <= 2 ? &tim->instance->CCMR1 : &tim->instance->CCMR2;
    unsigned shift = channel % 2 ? 0 : 8;
    tim->instance->CCR[channel - 1] = pulse;
    *ccmr = (*ccmr & ~(0xFFu << shift)) | (TIM_OC_PWM1 | TIM_OC_PRELOAD) << shift;
    tim->instance->CCER |= TIM_CCER_E(channel);
    tim->instance->CR1 |= TIM_CR1_CEN;
    return HAL_OK;
}

void hal_tim_irq_handler(hal_tim_t *tim)
{
    if (tim->instance->SR & TIM_UIF && tim->instance->DIER & TIM_UIF) {
        tim->instance->SR = ~TIM_UIF;
        hal_tim_period_elapsed_callback(tim);
    }
}
