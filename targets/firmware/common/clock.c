// SPDX-License-Identifier: GPL-2.0-or-later

#include "clock.h"

#include "chip/stm32f103.h"

void clock_72mhz(void)
{
    RCC->CR |= RCC_CR_HSEON;
    while (!(RCC->CR & RCC_CR_HSERDY)) {
    }
    // Two wait states above 48 MHz, and before the clock gets there (RM0008, 3.3.3).
    FLASH->ACR = FLASH_ACR_PRFTBE | FLASH_ACR_LATENCY_2;
    RCC->CFGR = RCC_CFGR_PLLSRC | (9u - 2u) << RCC_CFGR_PLLMUL_SHIFT | APB_DIV2 << RCC_CFGR_PPRE1_SHIFT;
    RCC->CR |= RCC_CR_PLLON;
    while (!(RCC->CR & RCC_CR_PLLRDY)) {
    }
    RCC->CFGR |= SYSCLK_PLL;
    while ((RCC->CFGR & RCC_CFGR_SWS) != SYSCLK_PLL << RCC_CFGR_SWS_SHIFT) {
    }
}

static uint32_t pll_hz(uint32_t cfgr)
{
    uint32_t factor = ((cfgr & RCC_CFGR_PLLMUL) >> RCC_CFGR_PLLMUL_SHIFT) + 2;
    if (factor > 16)
        factor = 16; // 1111 means 16 as 1110 does
    if (!(cfgr & RCC_CFGR_PLLSRC))
        return HSI_HZ / 2 * factor;
    return (cfgr & RCC_CFGR_PLLXTPRE ? HSE_HZ / 2 : HSE_HZ) * factor;
}

static uint32_t sysclk_hz(uint32_t cfgr)
{
    switch ((cfgr & RCC_CFGR_SWS) >> RCC_CFGR_SWS_SHIFT) {
    case SYSCLK_HSE:
        return HSE_HZ;
    case SYSCLK_PLL:
        return pll_hz(cfgr);
    default:
        return HSI_HZ;
    }
}

uint32_t clock_hclk_hz(void)
{
    static const uint8_t shift[16] = {[8] = 1, 2, 3, 4, 6, 7, 8, 9}; // there is no division by 32
    uint32_t cfgr = RCC->CFGR;
    return sysclk_hz(cfgr) >> shift[(cfgr & RCC_CFGR_HPRE) >> RCC_CFGR_HPRE_SHIFT];
}

static uint32_t apb_shift(uint32_t ppre) { return ppre < APB_DIV2 ? 0 : ppre - APB_DIV2 + 1; }

uint32_t clock_pclk1_hz(void)
{
    return clock_hclk_hz() >> apb_shift((RCC->CFGR & RCC_CFGR_PPRE1) >> RCC_CFGR_PPRE1_SHIFT);
}

uint32_t clock_pclk2_hz(void)
{
    return clock_hclk_hz() >> apb_shift((RCC->CFGR & RCC_CFGR_PPRE2) >> RCC_CFGR_PPRE2_SHIFT);
}
