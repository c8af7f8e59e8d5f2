// SPDX-License-Identifier: GPL-2.0-or-later
//
// The registers that these images use (RM0433: FLASH 4.9, PWR 6.8, RCC 8.7, GPIO 11.4, SYSCFG 12.3, EXTI 20.6, HSEM 10.4,
// USART 48.7).

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

enum { FLASH_IRQ = 4, RCC_IRQ = 5, USART3_IRQ = 39, EXTI15_10_IRQ = 40, HSEM_IRQ = 125, IRQ_COUNT = 150 };

static inline void interrupt_enable(unsigned irq, unsigned level)
{
    NVIC->IPR[irq] = (uint8_t)(level << 4);
    NVIC->ISER[irq / 32] = 1u << irq % 32;
}

// --- RCC

typedef struct {
    uint32_t CR;
    uint32_t HSICFGR;
    uint32_t CRRCR;
    uint32_t CSICFGR;
    uint32_t CFGR;
    uint32_t reserved0;
    uint32_t D1CFGR;
    uint32_t D2CFGR;
    uint32_t D3CFGR;
    uint32_t reserved1;
    uint32_t PLLCKSELR;
    uint32_t PLLCFGR;
    struct {
        uint32_t DIVR;
        uint32_t FRACR;
    } PLL[3];
    uint32_t reserved2;
    uint32_t D1CCIPR;
    uint32_t D2CCIP1R;
    uint32_t D2CCIP2R;
    uint32_t D3CCIPR;
    uint32_t reserved3;
    uint32_t CIER;
    uint32_t CIFR;
    uint32_t CICR;
    uint32_t reserved4;
    uint32_t BDCR;
    uint32_t CSR;
    uint32_t reserved5;
    uint32_t AHB3RSTR;
    uint32_t AHB1RSTR;
    uint32_t AHB2RSTR;
    uint32_t AHB4RSTR;
    uint32_t APB3RSTR;
    uint32_t APB1LRSTR;
    uint32_t APB1HRSTR;
    uint32_t APB2RSTR;
    uint32_t APB4RSTR;
    uint32_t GCR;
    uint32_t reserved6;
    uint32_t D3AMR;
    uint32_t reserved7[9];
    uint32_t RSR;
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
#define RCC_C1_AHB4ENR (*(volatile uint32_t *)0x58024540u) // AHB4ENR again, for CPU 1

#define RCC_CR_CSION (1u << 7)
#define RCC_CR_CSIRDY (1u << 8)
#define RCC_CR_HSEON (1u << 16)
#define RCC_CR_HSERDY (1u << 17)
#define RCC_CR_HSEBYP (1u << 18)
#define RCC_CR_PLL1ON (1u << 24)
#define RCC_CR_PLL1RDY (1u << 25)
#define RCC_CFGR_SW_PLL1 3u
#define RCC_CFGR_SWS (7u << 3)
#define RCC_AHB4_GPIO(port) (1u << ((port) - 'A'))
#define RCC_AHB4_HSEM (1u << 25)
#define RCC_AHB4_BKPSRAM (1u << 28)
#define RCC_APB1L_USART3 (1u << 18)
#define RCC_APB4_SYSCFG (1u << 1)

// --- PWR

typedef struct {
    uint32_t CR1;
    uint32_t CSR1;
    uint32_t CR2;
    uint32_t CR3;
    uint32_t CPUCR;
    uint32_t reserved0;
    uint32_t D3CR;
    uint32_t reserved1;
    uint32_t WKUPCR;
    uint32_t WKUPFR;
    uint32_t WKUPEPR;
} pwr_t;

#define PWR ((volatile pwr_t *)0x58024800u)

#define PWR_CR1_DBP (1u << 8)
#define PWR_CSR1_ACTVOSRDY (1u << 13)
#define PWR_CR3_LDOEN (1u << 1)
#define PWR_CR3_SCUEN (1u << 2)
#define PWR_D3CR_VOSRDY (1u << 13)
#define PWR_D3CR_VOS_SCALE1 (3u << 14)

// --- FLASH

typedef struct {
    uint32_t ACR;
    uint32_t KEYR;
    uint32_t OPTKEYR;
    uint32_t CR;
    uint32_t SR;
    uint32_t CCR;
    uint32_t OPTCR;
    uint32_t OPTSR_CUR;
} flash_t;

#define FLASH_ACR (*(volatile uint32_t *)0x52002000u)
#define FLASH_OPTCR (*(volatile uint32_t *)0x52002018u)
#define FLASH_OPTSR_CUR (*(volatile uint32_t *)0x5200201Cu)
#define FLASH_BOOT_CURR (*(volatile uint32_t *)0x52002040u)
#define FLASH(bank) ((volatile flash_t *)(0x52002000u + 0x100u * ((bank)-1)))

#define FLASH_CR_LOCK (1u << 0)
#define FLASH_CR_PG (1u << 1)
#define FLASH_CR_SER (1u << 2)
#define FLASH_CR_PSIZE_64 (3u << 4)
#define FLASH_CR_FW (1u << 6)
#define FLASH_CR_START (1u << 7)
#define FLASH_CR_SNB_SHIFT 8
#define FLASH_CR_EOPIE (1u << 16)
#define FLASH_SR_BSY (1u << 0)
#define FLASH_SR_WBNE (1u << 1)
#define FLASH_SR_QW (1u << 2)
#define FLASH_SR_EOP (1u << 16)
#define FLASH_SR_PGSERR (1u << 18)
#define FLASH_SR_STRBERR (1u << 19)
#define FLASH_SR_INCERR (1u << 21)

#define DBGMCU_IDC (*(volatile uint32_t *)0x5C001000u)
#define UNIQUE_ID ((volatile uint32_t *)0x1FF1E800u)
#define FLASH_KB (*(volatile uint16_t *)0x1FF1E880u)

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

#define GPIO(letter) ((volatile gpio_t *)(0x58020000u + 0x400u * ((letter) - 'A')))

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

// --- SYSCFG and EXTI

#define SYSCFG_EXTICR ((volatile uint32_t *)0x58000408u)
#define SYSCFG_PWRCR (*(volatile uint32_t *)0x5800042Cu)
#define SYSCFG_PWRCR_ODEN (1u << 0)

typedef struct {
    uint32_t RTSR1;
    uint32_t FTSR1;
    uint32_t SWIER1;
    uint32_t reserved[29];
    uint32_t CPUIMR1;
    uint32_t CPUEMR1;
    uint32_t CPUPR1; // write one to clear
} exti_t;

#define EXTI ((volatile exti_t *)0x58000000u)

// --- HSEM

typedef struct {
    uint32_t R[32];
    uint32_t RLR[32];
    uint32_t C1IER;
    uint32_t C1ICR;
    uint32_t C1ISR;
    uint32_t C1MISR;
} hsem_t;

#define HSEM ((volatile hsem_t *)0x58026400u)
#define HSEM_TAKEN (1u << 31)
#define HSEM_CPU (3u << 8) // the bus master identifier of the core

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
    uint32_t PRESC;
} usart_t;

#define USART3 ((volatile usart_t *)0x40004800u)

#define USART_CR1_UE (1u << 0)
#define USART_CR1_RE (1u << 2)
#define USART_CR1_TE (1u << 3)
#define USART_CR1_RXNEIE (1u << 5)
#define USART_ISR_ORE (1u << 3)
#define USART_ISR_RXNE (1u << 5)
#define USART_ISR_TC (1u << 6)
#define USART_ISR_TXE (1u << 7)
#define USART_ICR_ORECF (1u << 3)
