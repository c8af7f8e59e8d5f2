// SPDX-License-Identifier: GPL-2.0-or-later

#include "f767/clock.h"

#include "chip/cpu.h"
#include "f767/registers.h"

#define PLL_M 4u   // 8 MHz / 4 = 2 MHz
#define PLL_N 216u // 432 MHz, which P = 00 divides by 2
#define PLL_Q 9u   // 48 MHz

static void start_pll(void)
{
    RCC->CR |= RCC_CR_HSEBYP;
    RCC->CR |= RCC_CR_HSEON;
    while (!(RCC->CR & RCC_CR_HSERDY)) {
    }
    RCC->PLLCFGR = PLL_M | PLL_N << RCC_PLLCFGR_N_SHIFT | RCC_PLLCFGR_SRC_HSE | PLL_Q << RCC_PLLCFGR_Q_SHIFT;
    RCC->CR |= RCC_CR_PLLON;
}

static void start_over_drive(void)
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
    start_over_drive();
    while (!(RCC->CR & RCC_CR_PLLRDY)) {
    }
    // Above 210 MHz the flash takes seven wait states at 3.3 V (RM0410, table 7), from before the clock gets there.
    FLASH->ACR = FLASH_ACR_LATENCY_7 | FLASH_ACR_PRFTEN | FLASH_ACR_ARTEN;
    RCC->CFGR = RCC_CFGR_PPRE1_DIV4 | RCC_CFGR_PPRE2_DIV2;
    RCC->CFGR |= RCC_CFGR_SW_PLL;
    while ((RCC->CFGR & RCC_CFGR_SWS) != RCC_CFGR_SW_PLL << 2) {
    }
    start_instruction_cache();
}
