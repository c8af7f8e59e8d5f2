// SPDX-License-Identifier: GPL-2.0-or-later
//
// What high-density devices have beyond the others: RM0008, table 3 (addresses), sections 7.3 (gates), 12.5 (DAC), tables 63
// (interrupts) and 79 (requests of DMA2).

#pragma once

#include "chip/stm32f103.h"

#define RCC_AHB_DMA2 (1u << 1)
#define RCC_APB2_TIM8 (1u << 13)
#define RCC_APB1_TIM5 (1u << 3)
#define RCC_APB1_TIM6 (1u << 4)
#define RCC_APB1_TIM7 (1u << 5)
#define RCC_APB1_UART4 (1u << 19)
#define RCC_APB1_UART5 (1u << 20)
#define RCC_APB1_DAC (1u << 29)

#define TIM5 ((volatile tim_t *)0x40000C00u)
#define TIM6 ((volatile tim_t *)0x40001000u)
#define TIM7 ((volatile tim_t *)0x40001400u)
#define TIM8 ((volatile tim_t *)0x40013400u)
#define UART4 ((volatile usart_t *)0x40004C00u)
#define UART5 ((volatile usart_t *)0x40005000u)

#define DMA2 ((volatile dma_t *)0x40020400u) // its channels 6 and 7 are not there
#define DMA2_CHANNEL(n) (&DMA2->CHANNEL[(n) - 1])

#define GPIOD ((volatile gpio_t *)0x40011400u)
#define AFIO_MAPR_TIM5CH4_LSI (1u << 16)

typedef struct {
    uint32_t CR;
    uint32_t SWTRIGR;
    uint32_t DHR12R1;
    uint32_t DHR12L1;
    uint32_t DHR8R1;
    uint32_t DHR12R2;
    uint32_t DHR12L2;
    uint32_t DHR8R2;
    uint32_t DHR12RD;
    uint32_t DHR12LD;
    uint32_t DHR8RD;
    uint32_t DOR1;
    uint32_t DOR2;
} dac_t;

#define DAC ((volatile dac_t *)0x40007400u)

// Of channel 1; those of channel 2 are 16 bits higher
#define DAC_CR_EN (1u << 0)
#define DAC_CR_BOFF (1u << 1)
#define DAC_CR_TEN (1u << 2)
#define DAC_CR_TSEL_SHIFT 3
#define DAC_CR_NOISE (1u << 6)
#define DAC_CR_TRIANGLE (2u << 6)
#define DAC_CR_MAMP_SHIFT 8
#define DAC_CR_DMAEN (1u << 12)
#define DAC_CHANNEL_2(bits) ((bits) << 16)

enum dac_trigger { DAC_TIM6, DAC_TIM8, DAC_TIM7, DAC_TIM5, DAC_TIM2, DAC_TIM4, DAC_EXTI9, DAC_SOFTWARE };

enum high_density_irq {
    TIM8_BRK_IRQ = 43,
    TIM8_UP_IRQ = 44,
    TIM8_TRG_COM_IRQ = 45,
    TIM8_CC_IRQ = 46,
    TIM5_IRQ = 50,
    UART4_IRQ = 52,
    UART5_IRQ = 53,
    TIM6_IRQ = 54,
    TIM7_IRQ = 55,
    DMA2_CHANNEL1_IRQ = 56, // channel n: DMA2_CHANNEL1_IRQ + n - 1
    DMA2_CHANNEL4_5_IRQ = 59,
};
