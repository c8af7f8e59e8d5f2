// SPDX-License-Identifier: GPL-2.0-or-later
//
// Reset and clock control (RM0433, section 8.7), as far as the vehicle interface uses it.

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t CR;
    uint32_t reserved0[3];
    uint32_t CFGR;
    uint32_t reserved1;
    uint32_t D1CFGR;
    uint32_t D2CFGR;
    uint32_t D3CFGR;
    uint32_t reserved2;
    uint32_t PLLCKSELR;
    uint32_t PLLCFGR;
    struct {
        uint32_t DIVR;
        uint32_t FRACR;
    } PLL[3]; // PLL[n - 1] is PLLn
    uint32_t reserved3;
    uint32_t D1CCIPR;
    uint32_t D2CCIP1R;
    uint32_t D2CCIP2R;
    uint32_t D3CCIPR;
    uint32_t reserved4[30];
    uint32_t AHB3ENR;
    uint32_t AHB1ENR;
    uint32_t AHB2ENR;
    uint32_t AHB4ENR;
    uint32_t APB3ENR;
    uint32_t APB1LENR;
    uint32_t APB1HENR;
    uint32_t APB2ENR;
    uint32_t APB4ENR;
} rcc_t;

#define RCC ((volatile rcc_t *)0x58024400u)

_Static_assert(__builtin_offsetof(rcc_t, PLLCKSELR) == 0x28, "RCC layout");
_Static_assert(__builtin_offsetof(rcc_t, D3CCIPR) == 0x58, "RCC layout");
_Static_assert(__builtin_offsetof(rcc_t, APB4ENR) == 0xF4, "RCC layout");

#define RCC_CR_CSION (1u << 7)
#define RCC_CR_CSIRDY (1u << 8)
#define RCC_CR_PLLON(n) (1u << (24 + 2 * ((n) - 1)))
#define RCC_CR_PLLRDY(n) (2u << (24 + 2 * ((n) - 1)))

#define RCC_CFGR_SW_PLL1 3u
#define RCC_CFGR_SWS (7u << 3)
#define RCC_CFGR_SWS_PLL1 (3u << 3)

#define RCC_D1CFGR_HPRE_DIV2 (8u << 0)
#define RCC_D1CFGR_D1PPRE_DIV2 (4u << 4)
#define RCC_D2CFGR_D2PPRE1_DIV2 (4u << 4)
#define RCC_D2CFGR_D2PPRE2_DIV2 (4u << 8)
#define RCC_D3CFGR_D3PPRE_DIV2 (4u << 4)

#define RCC_PLLCKSELR_SRC_CSI 1u
#define RCC_PLLCKSELR_DIVM(n, by) ((uint32_t)(by) << (4 + 8 * ((n) - 1)))

#define RCC_PLLCFGR_FRACEN(n) (1u << 4 * ((n) - 1))
#define RCC_PLLCFGR_VCO_MEDIUM(n) (2u << 4 * ((n) - 1)) // 150 to 420 MHz; otherwise 192 to 836 (rev. V: 960)
#define RCC_PLLCFGR_IN_4_TO_8(n) (8u << 4 * ((n) - 1))  // the PLL's input, in MHz
#define RCC_PLLCFGR_DIVPEN(n) (1u << (16 + 3 * ((n) - 1)))

// Multiplied by `n`, divided by `p`, `q` and `r`
#define RCC_PLL_DIVR(n, p, q, r) (((n) - 1) | ((p) - 1) << 9 | ((q) - 1) << 16 | ((r) - 1) << 24)
#define RCC_PLL_FRACR(parts_of_8192) ((uint32_t)(parts_of_8192) << 3)

#define RCC_AHB1_DMA1 (1u << 0)
#define RCC_AHB1_DMA2 (1u << 1)
#define RCC_AHB1_ADC12 (1u << 5)
#define RCC_AHB4_GPIO(port) (1u << ((port) - 'A'))
#define RCC_APB1L_USART2 (1u << 17)
#define RCC_APB1L_USART3 (1u << 18)
#define RCC_APB4_SYSCFG (1u << 1)
