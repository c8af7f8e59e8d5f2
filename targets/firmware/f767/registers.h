// SPDX-License-Identifier: GPL-2.0-or-later
//
// The registers that these images use (RM0410: FLASH 3.7, PWR 4.4, RCC 5.3, GPIO 6.4, EXTI 11.9, USART 34.8).

#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "chip/core.h"

// --- the core (PM0253)

#define CPACR (*(volatile uint32_t *)0xE000ED88u)
#define CPACR_FPU (0xFu << 20) // full access to CP10 and CP11
#define ICIALLU (*(volatile uint32_t *)0xE000EF50u) // a write empties the instruction cache
#define CCR_IC (1u << 17)
#define DWT_LAR (*(volatile uint32_t *)0xE0001FB0u)

enum { FLASH_IRQ = 4, USART3_IRQ = 39, EXTI15_10_IRQ = 40, IRQ_COUNT = 110 };

static inline void interrupt_enable(unsigned irq, unsigned level)
{
    NVIC->IPR[irq] = (uint8_t)(level << 4);
    NVIC->ISER[irq / 32] = 1u << irq % 32;
}

// --- RCC

typedef struct {
    uint32_t CR;
    uint32_t PLLCFGR;
    uint32_t CFGR;
    uint32_t CIR;
    uint32_t AHB1RSTR;
    uint32_t reserved0[7];
    uint32_t AHB1ENR;
    uint32_t reserved1[3];
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
#define RCC_PLLCFGR_SRC_HSE (1u << 22)
#define RCC_PLLCFGR_Q_SHIFT 24
#define RCC_CFGR_SW_PLL 2u
#define RCC_CFGR_SWS (3u << 2)
#define RCC_CFGR_PPRE1_DIV4 (5u << 10)
#define RCC_CFGR_PPRE2_DIV2 (4u << 13)
#define RCC_AHB1_GPIO(port) (1u << ((port) - 'A'))
#define RCC_APB1_USART3 (1u << 18)
#define RCC_APB1_PWR (1u << 28)
#define RCC_APB2_SYSCFG (1u << 14)

// --- PWR

typedef struct {
    uint32_t CR1;
    uint32_t CSR1;
} pwr_t;

#define PWR ((volatile pwr_t *)0x40007000u)

#define PWR_CR1_VOS_SCALE1 (3u << 14)
#define PWR_CR1_ODEN (1u << 16)
#define PWR_CR1_ODSWEN (1u << 17)
#define PWR_CSR1_ODRDY (1u << 16)
#define PWR_CSR1_ODSWRDY (1u << 17)

// --- FLASH

typedef struct {
    uint32_t ACR;
    uint32_t KEYR;
    uint32_t OPTKEYR;
    uint32_t SR;
    uint32_t CR;
    uint32_t OPTCR;
    uint32_t OPTCR1;
} flash_t;

#define FLASH ((volatile flash_t *)0x40023C00u)

#define FLASH_ACR_LATENCY_7 7u
#define FLASH_ACR_PRFTEN (1u << 8)
#define FLASH_ACR_ARTEN (1u << 9)
#define FLASH_SR_EOP (1u << 0)
#define FLASH_SR_OPERR (1u << 1)
#define FLASH_SR_PGPERR (1u << 6)
#define FLASH_SR_ERSERR (1u << 7)
#define FLASH_SR_BSY (1u << 16)
#define FLASH_CR_PG (1u << 0)
#define FLASH_CR_SER (1u << 1)
#define FLASH_CR_SNB_SHIFT 3
#define FLASH_CR_PSIZE_32 (2u << 8)
#define FLASH_CR_STRT (1u << 16)
#define FLASH_CR_EOPIE (1u << 24)
#define FLASH_CR_LOCK (1u << 31)

#define DBGMCU_IDCODE (*(volatile uint32_t *)0xE0042000u)
#define UNIQUE_ID ((volatile uint32_t *)0x1FF0F420u)

// --- GPIO

typedef struct {
    uint32_t MODER;
    uint32_t OTYPER;
    uint32_t OSPEEDR;
    uint32_t PUPDR;
    uint32_t IDR;
    uint32_t ODR;
    uint32_t BSRR;
    uint32_t LCKR;
    uint32_t AFR[2];
} gpio_t;

#define GPIO(letter) ((volatile gpio_t *)(0x40020000u + 0x400u * ((letter) - 'A')))

enum pin_mode { PIN_INPUT, PIN_OUTPUT, PIN_ALTERNATE, PIN_ANALOG };

static inline void pin_mode(char port, unsigned pin, enum pin_mode mode)
{
    GPIO(port)->MODER = (GPIO(port)->MODER & ~(3u << 2 * pin)) | (uint32_t)mode << 2 * pin;
}

static inline void pin_alternate(char port, unsigned pin, unsigned function)
{
    volatile uint32_t *reg = &GPIO(port)->AFR[pin / 8];
    *reg = (*reg & ~(0xFu << pin % 8 * 4)) | function << pin % 8 * 4;
    pin_mode(port, pin, PIN_ALTERNATE);
}

static inline void pin_write(char port, unsigned pin, bool level) { GPIO(port)->BSRR = 1u << (level ? pin : pin + 16); }

static inline bool pin_read(char port, unsigned pin) { return GPIO(port)->IDR >> pin & 1u; }

// --- EXTI and the ports of its lines, in SYSCFG

typedef struct {
    uint32_t IMR;
    uint32_t EMR;
    uint32_t RTSR;
    uint32_t FTSR;
    uint32_t SWIER;
    uint32_t PR; // write one to clear
} exti_t;

#define EXTI ((volatile exti_t *)0x40013C00u)

#define SYSCFG_EXTICR ((volatile uint32_t *)0x40013808u)

// --- USART

typedef struct {
    uint32_t CR1;
    uint32_t CR2;
    uint32_t CR3;
    uint32_t BRR;
    uint32_t GTPR;
    uint32_t RTOR;
    uint32_t RQR;
    uint32_t ISR;
    uint32_t ICR;
    uint32_t RDR;
    uint32_t TDR;
} usart_t;

#define USART3 ((volatile usart_t *)0x40004800u)

#define USART_CR1_UE (1u << 0)
#define USART_CR1_RE (1u << 2)
#define USART_CR1_TE (1u << 3)
#define USART_CR1_RXNEIE (1u << 5)
#define USART_ISR_ORE (1u << 3)
#define USART_ISR_RXNE (1u << 5)
#define USART_ISR_TXE (1u << 7)
#define USART_ICR_ORECF (1u << 3)
