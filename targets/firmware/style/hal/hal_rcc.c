// SPDX-License-Identifier: GPL-2.0-or-later

#include "hal.h"

#define OSCILLATOR_TIMEOUT_MS 100u
#define SWITCH_TIMEOUT_MS 5000u

static hal_status_t wait_register(volatile uint32_t *address, uint32_t mask, uint32_t value, uint32_t timeout_ms)
{
    uint32_t start = hal_get_tick();
    while ((*address & mask) != value)
        if (hal_get_tick() - start > timeout_ms)
            return HAL_TIMEOUT;
    return HAL_OK;
}

static hal_status_t start_pll(uint32_t factor)
{
    RCC->CR &= ~RCC_CR_PLLON;
    if (wait_register(&RCC->CR, RCC_CR_PLLRDY, 0, OSCILLATOR_TIMEOUT_MS) != HAL_OK)
        return HAL_TIMEOUT;
    uint32_t others = RCC->CFGR & ~(RCC_CFGR_PLLMUL | RCC_CFGR_PLLSRC | RCC_CFGR_PLLXTPRE);
    RCC->CFGR = others | RCC_CFGR_PLLSRC | (factor - 2) << RCC_CFGR_PLLMUL_SHIFT;
    RCC->CR |= RCC_CR_PLLON;
    return wait_register(&RCC->CR, RCC_CR_PLLRDY, RCC_CR_PLLRDY, OSCILLATOR_TIMEOUT_MS);
}

hal_status_t hal_clock_config(const hal_clock_config_t *config)
{
    uint32_t source = config->pll_factor ? SYSCLK_PLL : config->hse_on ? SYSCLK_HSE : SYSCLK_HSI;
    if (config->hse_on) {
        RCC->CR |= RCC_CR_HSEON;
        if (wait_register(&RCC->CR, RCC_CR_HSERDY, RCC_CR_HSERDY, OSCILLATOR_TIMEOUT_MS) != HAL_OK)
            return HAL_TIMEOUT;
    }
    if (config->pll_factor && start_pll(config->pll_factor) != HAL_OK)
        return HAL_TIMEOUT;
    FLASH->ACR = (FLASH->ACR & ~7u) | config->flash_wait_states;
    if ((FLASH->ACR & 7u) != config->flash_wait_states)
        return HAL_ERROR;
    // The highest divider first: no bus is ever too fast on the way
    RCC->CFGR |= APB_DIV16 << RCC_CFGR_PPRE1_SHIFT | APB_DIV16 << RCC_CFGR_PPRE2_SHIFT;
    RCC->CFGR = (RCC->CFGR & ~RCC_CFGR_SW) | source;
    if (wait_register(&RCC->CFGR, RCC_CFGR_SWS, source << RCC_CFGR_SWS_SHIFT, SWITCH_TIMEOUT_MS) != HAL_OK)
        return HAL_TIMEOUT;
    RCC->CFGR = (RCC->CFGR & ~(RCC_CFGR_PPRE1 | RCC_CFGR_PPRE2)) | config->apb1_divider << RCC_CFGR_PPRE1_SHIFT;
    return hal_init_tick();
}
