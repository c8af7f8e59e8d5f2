// SPDX-License-Identifier: GPL-2.0-or-later
//
// Reset and clock control (RM0008, section 7).

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t CR;
    uint32_t CFGR;
    uint32_t CIR;
    uint32_t APB2RSTR;
    uint32_t APB1RSTR;
    uint32_t AHBENR;
    uint32_t APB2ENR;
    uint32_t APB1ENR;
    uint32_t BDCR;
    uint32_t CSR;
} rcc_t;

#define RCC ((volatile rcc_t *)0x40021000u)

#define RCC_CR_HSION (1u << 0)
#define RCC_CR_HSIRDY (1u << 1)
#define RCC_CR_HSITRIM_SHIFT 3
#define RCC_CR_HSEON (1u << 16)
#define RCC_CR_HSERDY (1u << 17)
#define RCC_CR_HSEBYP (1u << 18)
#define RCC_CR_CSSON (1u << 19)
#define RCC_CR_PLLON (1u << 24)
#define RCC_CR_PLLRDY (1u << 25)

#define RCC_CFGR_SW 0x3u
#define RCC_CFGR_SWS (0x3u << 2)
#define RCC_CFGR_SWS_SHIFT 2
#define RCC_CFGR_HPRE (0xFu << 4)
#define RCC_CFGR_HPRE_SHIFT 4
#define RCC_CFGR_PPRE1 (0x7u << 8)
#define RCC_CFGR_PPRE1_SHIFT 8
#define RCC_CFGR_PPRE2 (0x7u << 11)
#define RCC_CFGR_PPRE2_SHIFT 11
#define RCC_CFGR_PLLSRC (1u << 16)
#define RCC_CFGR_PLLXTPRE (1u << 17)
#define RCC_CFGR_PLLMUL (0xFu << 18)
#define RCC_CFGR_PLLMUL_SHIFT 18
#define RCC_CFGR_MCO_SHIFT 24

// SW and SWS
#define SYSCLK_HSI 0u
#define SYSCLK_HSE 1u
#define SYSCLK_PLL 2u

// PPRE1 and PPRE2
#define APB_DIV1 0u
#define APB_DIV2 4u
#define APB_DIV4 5u
#define APB_DIV8 6u
#define APB_DIV16 7u

#define RCC_CIR_LSIRDYF (1u << 0)
#define RCC_CIR_HSIRDYF (1u << 2)
#define RCC_CIR_HSERDYF (1u << 3)
#define RCC_CIR_PLLRDYF (1u << 4)
#define RCC_CIR_CSSF (1u << 7)
#define RCC_CIR_LSIRDYIE (1u << 8)
#define RCC_CIR_HSIRDYIE (1u << 10)
#define RCC_CIR_HSERDYIE (1u << 11)
#define RCC_CIR_PLLRDYIE (1u << 12)
#define RCC_CIR_LSIRDYC (1u << 16)
#define RCC_CIR_HSIRDYC (1u << 18)
#define RCC_CIR_HSERDYC (1u << 19)
#define RCC_CIR_PLLRDYC (1u << 20)

#define RCC_AHB_DMA1 (1u << 0)
#define RCC_AHB_SRAM (1u << 2)
#define RCC_AHB_FLITF (1u << 4)
#define RCC_AHB_CRC (1u << 6)

// Bits of APB2ENR and APB2RSTR
#define RCC_APB2_AFIO (1u << 0)
#define RCC_APB2_GPIOA (1u << 2)
#define RCC_APB2_GPIOB (1u << 3)
#define RCC_APB2_GPIOC (1u << 4)
#define RCC_APB2_TIM1 (1u << 11)
#define RCC_APB2_USART1 (1u << 14)

// Bits of APB1ENR and APB1RSTR
#define RCC_APB1_TIM2 (1u << 0)
#define RCC_APB1_TIM3 (1u << 1)
#define RCC_APB1_TIM4 (1u << 2)
#define RCC_APB1_WWDG (1u << 11)
#define RCC_APB1_USART2 (1u << 17)
#define RCC_APB1_USART3 (1u << 18)
#define RCC_APB1_BKP (1u << 27)
#define RCC_APB1_PWR (1u << 28)

#define RCC_BDCR_LSEON (1u << 0)
#define RCC_BDCR_LSERDY (1u << 1)
#define RCC_BDCR_BDRST (1u << 16)

#define RCC_CSR_LSION (1u << 0)
#define RCC_CSR_LSIRDY (1u << 1)
#define RCC_CSR_RMVF (1u << 24)
#define RCC_CSR_PINRSTF (1u << 26)
#define RCC_CSR_PORRSTF (1u << 27)
#define RCC_CSR_SFTRSTF (1u << 28)
#define RCC_CSR_IWDGRSTF (1u << 29)
#define RCC_CSR_WWDGRSTF (1u << 30)
#define RCC_CSR_LPWRRSTF (1u << 31)
#define RCC_CSR_CAUSES (0x3Fu << 26)
