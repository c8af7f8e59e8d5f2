// SPDX-License-Identifier: GPL-2.0-or-later
//
// Registers and bits for the self-tests of ports, USARTs and timers (RM0410: GPIO 6.4, TIM 25.4 to 28.4, USART 34.8).

#pragma once

#include "chip/cpu.h"
#include "f767/registers.h"

// --- RCC

#define RCC_APB1RSTR (*(volatile uint32_t *)0x40023820u)
#define RCC_DCKCFGR2 (*(volatile uint32_t *)0x40023890u)
#define RCC_DCKCFGR2_USART2_HSI (2u << 2)
#define RCC_APB1_TIM(number) (1u << ((number) - 2)) // 2 to 7
#define RCC_APB1_USART2 (1u << 17)
#define RCC_APB2_TIM1 (1u << 0)
#define RCC_APB2_TIM9 (1u << 16)
#define RCC_APB2_TIM10 (1u << 17)

// --- interrupts, which the tests look at without taking them

static inline bool pending(unsigned irq) { return NVIC->ISPR[irq / 32] >> irq % 32 & 1u; }

static inline void forget(unsigned irq)
{
    NVIC->ICPR[irq / 32] = 1u << irq % 32;
    DSB();
}

// --- time

static inline void cycles_start(void)
{
    DEMCR |= DEMCR_TRCENA;
    DWT_LAR = 0xC5ACCE55;
    DWT->CTRL |= 1;
}

static inline void wait_cycles(uint32_t cycles)
{
    uint32_t start = DWT->CYCCNT;
    while (DWT->CYCCNT - start < cycles) {
    }
}

// --- USART

#define USART2 ((volatile usart_t *)0x40004400u)

enum { USART2_IRQ = 38 };

enum {
    ISR_PE = 1u << 0,
    ISR_FE = 1u << 1,
    ISR_NF = 1u << 2,
    ISR_ORE = 1u << 3,
    ISR_IDLE = 1u << 4,
    ISR_RXNE = 1u << 5,
    ISR_TC = 1u << 6,
    ISR_TXE = 1u << 7,
    ISR_LBDF = 1u << 8,
    ISR_RTOF = 1u << 11,
    ISR_BUSY = 1u << 16,
    ISR_CMF = 1u << 17,
    ISR_SBKF = 1u << 18,
    ISR_RWU = 1u << 19,
    ISR_TEACK = 1u << 21,
    ISR_REACK = 1u << 22,
};
enum {
    CR1_TCIE = 1u << 6,
    CR1_PS = 1u << 9,
    CR1_PCE = 1u << 10,
    CR1_WAKE = 1u << 11,
    CR1_M0 = 1u << 12,
    CR1_MME = 1u << 13,
    CR1_OVER8 = 1u << 15,
    CR1_M1 = 1u << 28,
};
enum {
    CR2_ADDM7 = 1u << 4,
    CR2_LINEN = 1u << 14,
    CR2_TXINV = 1u << 17,
    CR2_DATAINV = 1u << 18,
    CR2_MSBFIRST = 1u << 19,
    CR2_RXINV = 1u << 16,
    CR2_RTOEN = 1u << 23,
};
#define CR2_ADD(address) ((uint32_t)(address) << 24)
enum { CR3_HDSEL = 1u << 3, CR3_ONEBIT = 1u << 11, CR3_OVRDIS = 1u << 12 };
enum { RQR_SBKRQ = 1u << 1, RQR_MMRQ = 1u << 2, RQR_RXFRQ = 1u << 3 };

// --- timers

typedef struct {
    uint32_t CR1;
    uint32_t CR2;
    uint32_t SMCR;
    uint32_t DIER;
    uint32_t SR;
    uint32_t EGR;
    uint32_t CCMR[2];
    uint32_t CCER;
    uint32_t CNT;
    uint32_t PSC;
    uint32_t ARR;
    uint32_t RCR;
    uint32_t CCR[4];
    uint32_t BDTR;
    uint32_t DCR;
    uint32_t DMAR;
    uint32_t OR;
    uint32_t CCMR3;
    uint32_t CCR5;
    uint32_t CCR6;
} timer_t;

#define TIM1 ((volatile timer_t *)0x40010000u)
#define TIM2 ((volatile timer_t *)0x40000000u)
#define TIM3 ((volatile timer_t *)0x40000400u)
#define TIM6 ((volatile timer_t *)0x40001000u)
#define TIM9 ((volatile timer_t *)0x40014000u)
#define TIM10 ((volatile timer_t *)0x40014400u)

enum { TIM1_BRK_TIM9_IRQ = 24, TIM2_IRQ = 28, TIM6_DAC_IRQ = 54 };

enum { TIM_CEN = 1u << 0, TIM_OPM = 1u << 3, TIM_UIFREMAP = 1u << 11, TIM_UIFCPY = 1u << 31 };
enum { TIM_UIF = 1u << 0, TIM_BIF = 1u << 7, TIM_B2IF = 1u << 8, TIM_CC5IF = 1u << 16, TIM_CC6IF = 1u << 17 };
enum { TIM_UG = 1u << 0, TIM_B2G = 1u << 8, TIM_PWM1 = 6u << 4, TIM_MOE = 1u << 15 };
