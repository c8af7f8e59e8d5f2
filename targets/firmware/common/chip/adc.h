// SPDX-License-Identifier: GPL-2.0-or-later
//
// Converters from analog (RM0008, section 11), with their gates (7.3.7) and their DMA channel (table 78).

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t SR;
    uint32_t CR1;
    uint32_t CR2;
    uint32_t SMPR1;
    uint32_t SMPR2;
    uint32_t JOFR[4];
    uint32_t HTR;
    uint32_t LTR;
    uint32_t SQR1;
    uint32_t SQR2;
    uint32_t SQR3;
    uint32_t JSQR;
    uint32_t JDR[4];
    uint32_t DR;
} adc_t;

#define ADC1 ((volatile adc_t *)0x40012400u)
#define ADC2 ((volatile adc_t *)0x40012800u)

#define RCC_APB2_ADC1 (1u << 9)
#define RCC_APB2_ADC2 (1u << 10)
#define RCC_CFGR_ADCPRE_SHIFT 14
#define DMA_ADC1 1

#define ADC_SR_AWD (1u << 0)
#define ADC_SR_EOC (1u << 1)
#define ADC_SR_JEOC (1u << 2)
#define ADC_SR_JSTRT (1u << 3)
#define ADC_SR_STRT (1u << 4)

#define ADC_CR1_EOCIE (1u << 5)
#define ADC_CR1_AWDIE (1u << 6)
#define ADC_CR1_JEOCIE (1u << 7)
#define ADC_CR1_SCAN (1u << 8)
#define ADC_CR1_AWDSGL (1u << 9)
#define ADC_CR1_JAUTO (1u << 10)
#define ADC_CR1_DISCEN (1u << 11)
#define ADC_CR1_DISCNUM_SHIFT 13
#define ADC_CR1_DUALMOD_SHIFT 16
#define ADC_CR1_JAWDEN (1u << 22)
#define ADC_CR1_AWDEN (1u << 23)

#define ADC_CR2_ADON (1u << 0)
#define ADC_CR2_CONT (1u << 1)
#define ADC_CR2_CAL (1u << 2)
#define ADC_CR2_RSTCAL (1u << 3)
#define ADC_CR2_DMA (1u << 8)
#define ADC_CR2_ALIGN (1u << 11)
#define ADC_CR2_JEXTSEL_SHIFT 12
#define ADC_CR2_JEXTTRIG (1u << 15)
#define ADC_CR2_EXTSEL_SHIFT 17
#define ADC_CR2_EXTTRIG (1u << 20)
#define ADC_CR2_JSWSTART (1u << 21)
#define ADC_CR2_SWSTART (1u << 22)
#define ADC_CR2_TSVREFE (1u << 23)

// EXTSEL and JEXTSEL
#define ADC_BY_TIM2_CC2 3u
#define ADC_BY_TIM3_TRGO 4u
#define ADC_BY_EXTI11 6u
#define ADC_BY_SOFTWARE 7u
#define ADC_INJECTED_BY_TIM2_TRGO 2u

#define ADC_SENSOR 16u
#define ADC_VREFINT 17u
