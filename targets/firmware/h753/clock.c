// SPDX-License-Identifier: GPL-2.0-or-later

#include "h753/clock.h"

#include "chip/cpu.h"
#include "h753/registers.h"

#define PLLSRC_CSI 1u
#define DIVM1(divider) ((divider) << 4)
#define RGE_4_TO_8 (2u << 2)
#define DIVP1EN (1u << 16)
#define DIVN(times) ((times)-1)
#define DIVP(divider) (((divider)-1) << 9)
#define HPRE_2 8u
#define PPRE_2 4u
#define LATENCY_4 4u
#define WRHIGHFREQ (2u << 4)

// The supply has to be chosen once after power-on; before that no voltage is ready (RM0433, section 6.4.1).
static void start_supply(void)
{
    PWR->CR3 = (PWR->CR3 & ~PWR_CR3_SCUEN) | PWR_CR3_LDOEN;
    while (!(PWR->CSR1 & PWR_CSR1_ACTVOSRDY)) {
    }
    PWR->D3CR = PWR_D3CR_VOS_SCALE1;
    while (!(PWR->D3CR & PWR_D3CR_VOSRDY)) {
    }
    RCC->APB4ENR |= RCC_APB4_SYSCFG;
    SYSCFG_PWRCR |= SYSCFG_PWRCR_ODEN;
    while (!(PWR->D3CR & PWR_D3CR_VOSRDY)) {
    }
}

static void start_pll(void)
{
    RCC->CR |= RCC_CR_CSION;
    while (!(RCC->CR & RCC_CR_CSIRDY)) {
    }
    RCC->PLLCKSELR = (RCC->PLLCKSELR & ~0x3F3u) | PLLSRC_CSI | DIVM1(1u);
    RCC->PLLCFGR = RGE_4_TO_8 | DIVP1EN;
    RCC->PLL[0].DIVR = DIVN(240u) | DIVP(2u);
    RCC->CR |= RCC_CR_PLL1ON;
    while (!(RCC->CR & RCC_CR_PLL1RDY)) {
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
    start_supply();
    start_pll();
    FLASH_ACR = LATENCY_4 | WRHIGHFREQ; // for 240 MHz on AXI (RM0433, table of wait states)
    RCC->D1CFGR = HPRE_2 | PPRE_2 << 4;
    RCC->D2CFGR = PPRE_2 << 4 | PPRE_2 << 8;
    RCC->D3CFGR = PPRE_2 << 4;
    RCC->CFGR |= RCC_CFGR_SW_PLL1;
    while ((RCC->CFGR & RCC_CFGR_SWS) != RCC_CFGR_SW_PLL1 << 3) {
    }
    start_instruction_cache();
}
