// SPDX-License-Identifier: GPL-2.0-or-later
//
// The supply of the core, which has to be raised for 480 MHz, and the flash memory's wait states (RM0433, sections 6.8, 12.3
// and 4.9).

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t CR1;
    uint32_t CSR1;
    uint32_t CR2;
    uint32_t CR3;
    uint32_t CPUCR;
    uint32_t reserved0;
    uint32_t D3CR;
} pwr_t;

#define PWR ((volatile pwr_t *)0x58024800u)

#define PWR_CSR1_ACTVOSRDY (1u << 13)
#define PWR_CR3_SUPPLY 7u // BYPASS, LDOEN and SCUEN: written once, LDOEN alone is the LDO
#define PWR_CR3_LDOEN (1u << 1)
#define PWR_D3CR_VOSRDY (1u << 13)
#define PWR_D3CR_VOS1 (3u << 14)

#define SYSCFG_PWRCR (*(volatile uint32_t *)0x5800042Cu)
#define SYSCFG_PWRCR_ODEN (1u << 0) // VOS1 becomes VOS0

#define FLASH_ACR (*(volatile uint32_t *)0x52002000u)
#define FLASH_ACR_LATENCY_4 4u
#define FLASH_ACR_WRHIGHFREQ_2 (2u << 4)
