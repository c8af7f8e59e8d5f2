// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/board/clock.h"

#include "chip/core.h"
#include "chip/core_m7.h"
#include "chip/cpu.h"
#include "rover/chip/power.h"
#include "rover/chip/rcc.h"

#define PLL_M 4u   // 8 MHz / 4 = 2 MHz, which RM0410 recommends against jitter
#define PLL_N 216u // 432 MHz
#define PLL_P 0u   // 00: divided by 2
#define PLL_Q 9u   // 48 MHz
#define PLL_R 2u

static void start_pll(void)
{
    RCC->CR |= RCC_CR_HSEBYP;
    RCC->CR |= RCC_CR_HSEON;
    while (!(RCC->CR & RCC_CR_HSERDY)) {
    }
    RCC->PLLCFGR = PLL_M | PLL_N << RCC_PLLCFGR_N_SHIFT | PLL_P << RCC_PLLCFGR_P_SHIFT | RCC_PLLCFGR_SRC_HSE |
                   PLL_Q << RCC_PLLCFGR_Q_SHIFT | PLL_R << RCC_PLLCFGR_R_SHIFT;
    RCC->CR |= RCC_CR_PLLON;
}

// Above 180 MHz the regulator has to be over-driven, in this order, before the clock is switched (RM0410, 4.1.6).
static void over_drive(void)
{
    PWR->CR1 |= PWR_CR1_ODEN;
    while (!(PWR->CSR1 & PWR_CSR1_ODRDY)) {
    }
    PWR->CR1 |= PWR_CR1_ODSWEN;
    while (!(PWR->CSR1 & PWR_CSR1_ODSWRDY)) {
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
    RCC->APB1ENR |= RCC_APB1_PWR;
    PWR->CR1 |= PWR_CR1_VOS_SCALE1;
    start_pll();
    over_drive();
    while (!(RCC->CR & RCC_CR_PLLRDY)) {
    }
    // Seven wait states for more than 210 MHz at 3.3 V (RM0410, table 7), and before the clock gets there.
    FLASH_ACR = FLASH_ACR_LATENCY_7 | FLASH_ACR_PRFTEN | FLASH_ACR_ARTEN;
    RCC->CFGR = APB_DIV4 << RCC_CFGR_PPRE1_SHIFT | APB_DIV2 << RCC_CFGR_PPRE2_SHIFT;
    RCC->CFGR |= RCC_CFGR_SW_PLL;
    while ((RCC->CFGR & RCC_CFGR_SWS) != RCC_CFGR_SW_PLL << RCC_CFGR_SWS_SHIFT) {
    }
    start_instruction_cache();
}
