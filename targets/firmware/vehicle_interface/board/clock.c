// SPDX-License-Identifier: GPL-2.0-or-later

#include "vehicle_interface/board/clock.h"

#include "chip/core.h"
#include "chip/core_m7.h"
#include "chip/cpu.h"
#include "vehicle_interface/chip/power.h"
#include "vehicle_interface/chip/rcc.h"

static void wait_for(volatile uint32_t *reg, uint32_t flag)
{
    while (!(*reg & flag)) {
    }
}

// 480 MHz need VOS0, which is VOS1 and over-drive (RM0433, section 6.6.2). The supply can be chosen once after power-up.
static void raise_supply(void)
{
    PWR->CR3 = (PWR->CR3 & ~PWR_CR3_SUPPLY) | PWR_CR3_LDOEN;
    wait_for(&PWR->CSR1, PWR_CSR1_ACTVOSRDY);
    PWR->D3CR = PWR_D3CR_VOS1;
    wait_for(&PWR->D3CR, PWR_D3CR_VOSRDY);
    RCC->APB4ENR |= RCC_APB4_SYSCFG;
    (void)RCC->APB4ENR; // a clock that was just switched on takes two cycles (RM0433, section 8.5.10)
    SYSCFG_PWRCR |= SYSCFG_PWRCR_ODEN;
    wait_for(&PWR->D3CR, PWR_D3CR_VOSRDY);
}

static void start_plls(void)
{
    RCC->CR |= RCC_CR_CSION;
    wait_for(&RCC->CR, RCC_CR_CSIRDY);
    RCC->PLLCKSELR = RCC_PLLCKSELR_SRC_CSI | RCC_PLLCKSELR_DIVM(1, 1) | RCC_PLLCKSELR_DIVM(2, 1);
    RCC->PLL[0].DIVR = RCC_PLL_DIVR(240u, 2u, 4u, 2u); // 960 MHz / 2
    RCC->PLL[1].DIVR = RCC_PLL_DIVR(37u, 2u, 2u, 2u);  // 37.5 * 4 MHz / 2
    RCC->PLL[1].FRACR = RCC_PLL_FRACR(4096u);
    RCC->PLLCFGR = RCC_PLLCFGR_IN_4_TO_8(1) | RCC_PLLCFGR_DIVPEN(1) | RCC_PLLCFGR_IN_4_TO_8(2) | RCC_PLLCFGR_VCO_MEDIUM(2) |
                   RCC_PLLCFGR_FRACEN(2) | RCC_PLLCFGR_DIVPEN(2);
    RCC->CR |= RCC_CR_PLLON(1) | RCC_CR_PLLON(2);
    wait_for(&RCC->CR, RCC_CR_PLLRDY(1));
    wait_for(&RCC->CR, RCC_CR_PLLRDY(2));
}

// Four wait states up to 240 MHz of HCLK at VOS0 (RM0433, table 17), and before the clock gets there; the buses' dividers, too.
static void switch_over(void)
{
    FLASH_ACR = FLASH_ACR_LATENCY_4 | FLASH_ACR_WRHIGHFREQ_2;
    wait_for(&FLASH_ACR, FLASH_ACR_LATENCY_4);
    RCC->D1CFGR = RCC_D1CFGR_HPRE_DIV2 | RCC_D1CFGR_D1PPRE_DIV2;
    RCC->D2CFGR = RCC_D2CFGR_D2PPRE1_DIV2 | RCC_D2CFGR_D2PPRE2_DIV2;
    RCC->D3CFGR = RCC_D3CFGR_D3PPRE_DIV2;
    RCC->CFGR = RCC_CFGR_SW_PLL1;
    while ((RCC->CFGR & RCC_CFGR_SWS) != RCC_CFGR_SWS_PLL1) {
    }
}

static void start_instruction_cache(void)
{
    ICIALLU = 0;
    DSB();
    ISB();
    SCB->CCR |= CCR_IC;
    DSB();
    ISB();
}

void clock_start(void)
{
    raise_supply();
    start_plls();
    switch_over();
    start_instruction_cache();
}
