// SPDX-License-Identifier: GPL-2.0-or-later
//
// Registers and bits for the self-tests of USART, DMA and the ADCs (RM0433: DMA 15.5, DMAMUX 17.6, ADC 25.5 and 25.6, TIM6
// 42.4, USART 48.7).

#pragma once

#include "chip/cpu.h"
#include "cycles.h"
#include "h753/registers.h"

#define RCC_AHB1_DMA1 (1u << 0)
#define RCC_AHB1_DMA2 (1u << 1)
#define RCC_AHB4_ADC3 (1u << 24)
#define RCC_APB1L_TIM6 (1u << 4)
#define RCC_APB1L_USART2 (1u << 17)
#define RCC_ADC_PER (2u << 16) // of D3CCIPR: per_ck, which is HSI after a reset, at 64 MHz
#define RCC_USART234578_CSI 4u // of D2CCIP2R

enum { DMA1_S0_IRQ = 11, USART2_IRQ = 38, DMA2_S0_IRQ = 56, ADC3_IRQ = 127 };

// The debug blocks of a Cortex-M7 ignore writes until they are unlocked.
static inline void counter_start(void)
{
    DEMCR |= DEMCR_TRCENA;
    DWT_LAR = 0xC5ACCE55;
    cycles_start();
}

// --- USART, with FIFOs

#define USART2 ((volatile usart_t *)0x40004400u)

enum {
    CR1_IDLEIE = 1u << 4,
    CR1_FIFOEN = 1u << 29,
    CR2_RTOEN = 1u << 23,
    CR3_HDSEL = 1u << 3,
    CR3_DMAR = 1u << 6,
    CR3_DMAT = 1u << 7,
    CR3_OVRDIS = 1u << 12,
    CR3_TXFTIE = 1u << 23,
    CR3_RXFTIE = 1u << 28,
    RQR_RXFRQ = 1u << 3,
    RQR_TXFRQ = 1u << 4,
    ISR_IDLE = 1u << 4,
    ISR_RTOF = 1u << 11,
    ISR_TXFE = 1u << 23,
    ISR_RXFF = 1u << 24,
    ISR_TCBGT = 1u << 25,
    ISR_RXFT = 1u << 26,
    ISR_TXFT = 1u << 27,
};
#define CR3_RXFTCFG(field) ((uint32_t)(field) << 25)
#define CR3_TXFTCFG(field) ((uint32_t)(field) << 29)

// --- TIM6

typedef struct {
    uint32_t CR1;
    uint32_t CR2;
    uint32_t reserved0;
    uint32_t DIER;
    uint32_t SR;
    uint32_t EGR;
    uint32_t reserved1[3];
    uint32_t CNT;
    uint32_t PSC;
    uint32_t ARR;
} basic_timer_t;

#define TIM6 ((volatile basic_timer_t *)0x40001000u)

// --- DMA and its multiplexer

typedef struct {
    uint32_t CR;
    uint32_t NDTR;
    uint32_t PAR;
    uint32_t M0AR;
    uint32_t M1AR;
    uint32_t FCR;
} stream_t;

typedef struct {
    uint32_t LISR;
    uint32_t HISR;
    uint32_t LIFCR;
    uint32_t HIFCR;
    stream_t S[8];
} dma_t;

#define DMA1 ((volatile dma_t *)0x40020000u)
#define DMA2 ((volatile dma_t *)0x40020400u)
#define DMAMUX1 ((volatile uint32_t *)0x40020800u) // by stream; those of DMA2 from 8 on

enum {
    DMA_EN = 1u << 0,
    DMA_TEIE = 1u << 2,
    DMA_TCIE = 1u << 4,
    DMA_TO_PERIPHERAL = 1u << 6,
    DMA_BETWEEN = 2u << 6,
    DMA_CIRC = 1u << 8,
    DMA_PINC = 1u << 9,
    DMA_MINC = 1u << 10,
    DMA_WORDS = 2u << 11 | 2u << 13,
    DMA_TRBUFF = 1u << 20,
};

// Flags of stream 0 in LISR; those of stream 1 stand 6 bits higher, those of stream 2 16.
enum { DMA_TEIF = 1u << 3, DMA_HTIF = 1u << 4, DMA_TCIF = 1u << 5, DMA_ALL = 0x3Du };

enum { REQUEST_USART2_RX = 43, REQUEST_USART2_TX = 44, REQUEST_TIM6_UP = 69, REQUEST_ADC3 = 115 };

// --- ADC

typedef struct {
    uint32_t ISR;
    uint32_t IER;
    uint32_t CR;
    uint32_t CFGR;
    uint32_t CFGR2;
    uint32_t SMPR[2];
    uint32_t PCSEL;
    uint32_t LTR1;
    uint32_t HTR1;
    uint32_t reserved0[2];
    uint32_t SQR[4];
    uint32_t DR;
    uint32_t reserved1[2];
    uint32_t JSQR;
    uint32_t reserved2[4];
    uint32_t OFR[4];
    uint32_t reserved3[4];
    uint32_t JDR[4];
} adc_t;

#define ADC3 ((volatile adc_t *)0x58026000u)
#define ADC3_CCR (*(volatile uint32_t *)0x58026308u)

enum {
    ADC_ADRDY = 1u << 0,
    ADC_EOSMP = 1u << 1,
    ADC_EOC = 1u << 2,
    ADC_EOS = 1u << 3,
    ADC_OVR = 1u << 4,
    ADC_JEOC = 1u << 5,
    ADC_JEOS = 1u << 6,
    ADC_AWD1 = 1u << 7,
    ADC_LDORDY = 1u << 12,
    ADC_EN = 1u << 0,
    ADC_DIS = 1u << 1,
    ADC_START = 1u << 2,
    ADC_JSTART = 1u << 3,
    ADC_STOP = 1u << 4,
    ADC_BOOST_50_MHZ = 3u << 8,
    ADC_LINEAR = 1u << 16,
    ADC_REGULATOR = 1u << 28,
    ADC_CALIBRATE = 1u << 31,
    ADC_DMA_ONCE = 1u,
    ADC_DMA_CIRCULAR = 3u,
    ADC_12_BITS = 6u << 2, // revision V
    ADC_8_BITS = 7u << 2,
    ADC_BY_TIM6 = 13u << 5 | 1u << 10, // its rising edges
    ADC_OVERWRITE = 1u << 12,
    ADC_CONTINUOUS = 1u << 13,
    ADC_WATCH_ALL = 1u << 23,
    ADC_JQDIS = 1u << 31,
    ADC_PRESC_16 = 7u << 18,
    ADC_VREFINT_ON = 1u << 22,
    ADC_SENSOR_ON = 1u << 23,
    ADC_VBAT_ON = 1u << 24,
};
enum { CHANNEL_VBAT = 17, CHANNEL_SENSOR = 18, CHANNEL_VREFINT = 19 }; // of ADC3
