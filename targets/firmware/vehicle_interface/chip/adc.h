// SPDX-License-Identifier: GPL-2.0-or-later
//
// ADC1, and what it shares with ADC2 (RM0433, sections 25.6 and 25.7).

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t ISR;
    uint32_t IER;
    uint32_t CR;
    uint32_t CFGR;
    uint32_t CFGR2;
    uint32_t SMPR[2];
    uint32_t PCSEL;
    uint32_t reserved0[4];
    uint32_t SQR[4];
    uint32_t DR;
} adc_t;

#define ADC1 ((volatile adc_t *)0x40022000u)
#define ADC12_CCR (*(volatile uint32_t *)0x40022308u)

_Static_assert(__builtin_offsetof(adc_t, DR) == 0x40, "ADC layout");

#define ADC_ISR_ADRDY (1u << 0)
#define ADC_ISR_LDORDY (1u << 12)

#define ADC_CR_ADEN (1u << 0)
#define ADC_CR_ADSTART (1u << 2)
#define ADC_CR_ADVREGEN (1u << 28)
#define ADC_CR_DEEPPWD (1u << 29)

#define ADC_CFGR_DMA_CIRCULAR 3u
#define ADC_CFGR_CONT (1u << 13)

#define ADC_SMP_387_5 6u
#define ADC_SMPR(channel, time) ((uint32_t)(time) << 3 * ((channel) % 10))
#define ADC_SQR1(count, first, second) (((count) - 1) | (first) << 6 | (second) << 12)

#define ADC_CCR_PRESC_256 (11u << 18) // of the clock that RCC gives it
