// SPDX-License-Identifier: GPL-2.0-or-later
//
// Flash memory interface (RM0008, 3.3.3; ST PM0075, section 3) and what ST wrote into the system memory (RM0008, 30).

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t ACR;
    uint32_t KEYR;
    uint32_t OPTKEYR;
    uint32_t SR;
    uint32_t CR;
    uint32_t AR;
    uint32_t reserved;
    uint32_t OBR;
    uint32_t WRPR;
} flash_t;

#define FLASH ((volatile flash_t *)0x40022000u)

#define FLASH_ACR_LATENCY_2 2u
#define FLASH_ACR_PRFTBE (1u << 4)
#define FLASH_ACR_PRFTBS (1u << 5)

#define FLASH_KEY1 0x45670123u
#define FLASH_KEY2 0xCDEF89ABu

#define FLASH_SR_BSY (1u << 0)
#define FLASH_SR_PGERR (1u << 2)
#define FLASH_SR_WRPRTERR (1u << 4)
#define FLASH_SR_EOP (1u << 5)

#define FLASH_CR_PG (1u << 0)
#define FLASH_CR_PER (1u << 1)
#define FLASH_CR_OPTPG (1u << 4)
#define FLASH_CR_OPTER (1u << 5)
#define FLASH_CR_STRT (1u << 6)
#define FLASH_CR_LOCK (1u << 7)
#define FLASH_CR_OPTWRE (1u << 9)
#define FLASH_CR_ERRIE (1u << 10)
#define FLASH_CR_EOPIE (1u << 12)

#define FLASH_OBR_OPTERR (1u << 0)
#define FLASH_OBR_RDPRT (1u << 1)

#define FLASH_PAGE_BYTES 1024u // medium density (RM0008, table 5)

// Option bytes: each a half-word of the byte and its complement, which the hardware computes (PM0075, 2.5)
#define OPTION_RDP ((volatile uint16_t *)0x1FFFF800u)
#define OPTION_WRP1 ((volatile uint16_t *)0x1FFFF80Au)
#define OPTION_RDP_UNPROTECTED 0x00A5u

#define FLASH_SIZE_KB (*(volatile uint16_t *)0x1FFFF7E0u)
#define UNIQUE_ID ((volatile uint32_t *)0x1FFFF7E8u) // 96 bits
