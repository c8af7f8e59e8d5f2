// SPDX-License-Identifier: GPL-2.0-or-later
//
// Registers and bits for the self-tests of DMA, I2C and the ADCs (RM0410: DMA 8.5, ADC 15.13, I2C 33.7).

#pragma once

#include "f767/blocks.h"

#define RCC_AHB1_DMA1 (1u << 21)
#define RCC_AHB1_DMA2 (1u << 22)
#define RCC_APB1_I2C1 (1u << 21)
#define RCC_APB1RSTR_I2C1 (1u << 21)
#define RCC_APB2_ADC1 (1u << 8)

// --- DMA

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

#define DMA1 ((volatile dma_t *)0x40026000u)
#define DMA2 ((volatile dma_t *)0x40026400u)

enum { DMA2_S0_IRQ = 56 };

enum {
    DMA_EN = 1u << 0,
    DMA_TEIE = 1u << 2,
    DMA_HTIE = 1u << 3,
    DMA_TCIE = 1u << 4,
    DMA_TO_PERIPHERAL = 1u << 6,
    DMA_BETWEEN = 2u << 6,
    DMA_CIRC = 1u << 8,
    DMA_PINC = 1u << 9,
    DMA_MINC = 1u << 10,
    DMA_PINCOS = 1u << 15,
    DMA_DBM = 1u << 18,
    DMA_CT = 1u << 19,
    DMA_MBURST_4 = 1u << 23,
};
#define DMA_PSIZE(shift) ((uint32_t)(shift) << 11)
#define DMA_MSIZE(shift) ((uint32_t)(shift) << 13)
#define DMA_CHANNEL(number) ((uint32_t)(number) << 25)
enum { FCR_DMDIS = 1u << 2, FCR_FULL = 3u, FCR_EMPTY = 4u << 3 };

// Flags of stream 0 in LISR.
enum { DMA_FEIF = 1u << 0, DMA_TEIF = 1u << 3, DMA_HTIF = 1u << 4, DMA_TCIF = 1u << 5, DMA_ALL = 0x3Du };

// --- I2C

typedef struct {
    uint32_t CR1;
    uint32_t CR2;
    uint32_t OAR1;
    uint32_t OAR2;
    uint32_t TIMINGR;
    uint32_t TIMEOUTR;
    uint32_t ISR;
    uint32_t ICR;
    uint32_t PECR;
    uint32_t RXDR;
    uint32_t TXDR;
} i2c_t;

#define I2C1 ((volatile i2c_t *)0x40005400u)

enum { I2C1_EV_IRQ = 31, I2C1_ER_IRQ = 32 };

enum { I2C_PE = 1u << 0, I2C_NACKIE = 1u << 4, I2C_STOPIE = 1u << 5, I2C_ANFOFF = 1u << 12 };
enum { I2C_READ = 1u << 10, I2C_START = 1u << 13, I2C_STOP = 1u << 14, I2C_AUTOEND = 1u << 25 };
#define I2C_NBYTES(count) ((uint32_t)(count) << 16)
enum {
    I2C_TXE = 1u << 0,
    I2C_TXIS = 1u << 1,
    I2C_NACKF = 1u << 4,
    I2C_STOPF = 1u << 5,
    I2C_TC = 1u << 6,
    I2C_BUSY = 1u << 15,
};

// --- ADC

typedef struct {
    uint32_t SR;
    uint32_t CR1;
    uint32_t CR2;
    uint32_t SMPR1;
    uint32_t SMPR2;
    uint32_t JOFR[4];
    uint32_t HTR;
    uint32_t LTR;
    uint32_t SQR[3];
    uint32_t JSQR;
    uint32_t JDR[4];
    uint32_t DR;
} adc_t;

#define ADC1 ((volatile adc_t *)0x40012000u)
#define ADC_CSR (*(volatile uint32_t *)0x40012300u)
#define ADC_CCR (*(volatile uint32_t *)0x40012304u)

enum { ADC_IRQ = 18 };

enum { ADC_AWD = 1u << 0, ADC_EOC = 1u << 1, ADC_JEOC = 1u << 2, ADC_JSTRT = 1u << 3, ADC_STRT = 1u << 4, ADC_OVR = 1u << 5 };
enum { ADC_EOCIE = 1u << 5, ADC_SCAN = 1u << 8, ADC_DISCEN = 1u << 11, ADC_AWDEN = 1u << 23, ADC_RES_8 = 2u << 24 };
enum {
    ADC_ON = 1u << 0,
    ADC_CONT = 1u << 1,
    ADC_DMA = 1u << 8,
    ADC_EOCS = 1u << 10,
    ADC_ALIGN = 1u << 11,
    ADC_JSWSTART = 1u << 22,
    ADC_EXTSEL_TIM6 = 13u << 24,
    ADC_EXTEN_RISING = 1u << 28,
    ADC_SWSTART = 1u << 30,
};
enum { ADC_PRESCALER_4 = 1u << 16, ADC_VBATE = 1u << 22, ADC_TSVREFE = 1u << 23 };
enum { ADC_VREFINT = 17, ADC_SENSOR = 18 };
