// SPDX-License-Identifier: GPL-2.0-or-later
//
// Clocks: first HSI, then HSE without a PLL, then the PLL; each field of CFGR by an access of its own (RM0008, section 7.3).

#include "opencm3.h"

uint32_t rcc_ahb_frequency = 8000000, rcc_apb1_frequency = 8000000, rcc_apb2_frequency = 8000000;

static void osc_on_and_ready(uint32_t on, uint32_t ready)
{
    RCC->CR |= on;
    while (!(RCC->CR & ready)) {
    }
}

static void set_cfgr(uint32_t mask, uint32_t value) { RCC->CFGR = (RCC->CFGR & ~mask) | value; }

void rcc_clock_setup_in_hse_8mhz_out_72mhz(void)
{
    osc_on_and_ready(RCC_CR_HSION, RCC_CR_HSIRDY);
    set_cfgr(RCC_CFGR_SW, SYSCLK_HSI);
    osc_on_and_ready(RCC_CR_HSEON, RCC_CR_HSERDY);
    set_cfgr(RCC_CFGR_SW, SYSCLK_HSE);
    set_cfgr(RCC_CFGR_HPRE, 0);
    set_cfgr(3u << RCC_CFGR_ADCPRE_SHIFT, 2u << RCC_CFGR_ADCPRE_SHIFT); // 12 MHz
    set_cfgr(RCC_CFGR_PPRE1, APB_DIV2 << RCC_CFGR_PPRE1_SHIFT);
    set_cfgr(RCC_CFGR_PPRE2, 0);
    FLASH->ACR = (FLASH->ACR & ~7u) | FLASH_ACR_LATENCY_2;
    set_cfgr(RCC_CFGR_PLLMUL, (9u - 2u) << RCC_CFGR_PLLMUL_SHIFT);
    set_cfgr(RCC_CFGR_PLLSRC, RCC_CFGR_PLLSRC);
    set_cfgr(RCC_CFGR_PLLXTPRE, 0);
    osc_on_and_ready(RCC_CR_PLLON, RCC_CR_PLLRDY);
    set_cfgr(RCC_CFGR_SW, SYSCLK_PLL); // not waited for
    rcc_ahb_frequency = rcc_apb2_frequency = 72000000;
    rcc_apb1_frequency = 36000000;
}

static volatile uint32_t *register_at(uint32_t offset) { return (volatile uint32_t *)((uintptr_t)RCC + offset); }

void rcc_periph_clock_enable(enum rcc_gate gate) { *register_at(gate >> 5) |= 1u << (gate & 31u); }

void rcc_periph_reset_pulse(enum rcc_gate gate)
{
    volatile uint32_t *reset = register_at((gate >> 5) - 0x0C); // APB2RSTR and APB1RSTR stand 12 bytes before the gates
    *reset |= 1u << (gate & 31u);
    *reset &= ~(1u << (gate & 31u));
}
