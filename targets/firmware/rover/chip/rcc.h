// SPDX-License-Identifier: GPL-2.0-or-later
//
// Reset and clock control (RM0410, section 5), as far as the rover uses it.

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t CR;
    uint32_t PLLCFGR;
    uint32_t CFGR;
    uint32_t CIR;
    uint32_t AHB1RSTR;
    uint32_t AHB2RSTR;
    uint32_t AHB3RSTR;
    uint32_t reserved0;
    uint32_t APB1RSTR;
    uint32_t APB2RSTR;
    uint32_t reserved1[2];
    uint32_t AHB1ENR;
    uint32_t AHB2ENR;
    uint32_t AHB3ENR;
    uint32_t reserved2;
    uint32_t APB1ENR;
    uint32_t APB2ENR;
} rcc_t;

#define RCC ((volatile rcc_t *)0x40023800u)

#define RCC_CR_HSEON (1u << 16)
#define RCC_CR_HSERDY (1u << 17)
#define RCC_CR_HSEBYP (1u << 18)
#define RCC_CR_PLLON (1u << 24)
#define RCC_CR_PLLRDY (1u << 25)

#define RCC_PLLCFGR_N_SHIFT 6
#define RCC_PLLCFGR_P_SHIFT 16
#define RCC_PLLCFGR_SRC_HSE (1u << 22)
#define RCC_PLLCFGR_Q_SHIFT 24
#define RCC_PLLCFGR_R_SHIFT 28

#define RCC_CFGR_SW_PLL 2u
#define RCC_CFGR_SWS_SHIFT 2
#define RCC_CFGR_SWS (3u << RCC_CFGR_SWS_SHIFT)
#define RCC_CFGR_PPRE1_SHIFT 10
#define RCC_CFGR_PPRE2_SHIFT 13
#define APB_DIV2 4u
#define APB_DIV4 5u

#define RCC_AHB1_GPIO(port) (1u << ((port) - 'A'))
#define RCC_AHB1_DMA1 (1u << 21)

#define RCC_AHB3_QUADSPI (1u << 1)

#define RCC_APB1_TIM2 (1u << 0)
#define RCC_APB1_TIM5 (1u << 3)
#define RCC_APB1_USART2 (1u << 17)
#define RCC_APB1_USART3 (1u << 18)
#define RCC_APB1_I2C1 (1u << 21)
#define RCC_APB1_PWR (1u << 28)

#define RCC_APB2_TIM1 (1u << 0)
#define RCC_APB2_SYSCFG (1u << 14)
