// SPDX-License-Identifier: GPL-2.0-or-later
//
// The regulator, which has to be told of 216 MHz, and the flash memory's wait states (RM0410, sections 4.4 and 3.7).

#pragma once

#include <stdint.h>

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

#define FLASH_ACR (*(volatile uint32_t *)0x40023C00u)

#define FLASH_ACR_LATENCY_7 7u
#define FLASH_ACR_PRFTEN (1u << 8)
#define FLASH_ACR_ARTEN (1u << 9)
