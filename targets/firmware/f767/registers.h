// SPDX-License-Identifier: GPL-2.0-or-later
//
// Registers that the rover does not need: FLASH (RM0410, section 3.7), DBGMCU, the signature.

#pragma once

#include <stdint.h>

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
#define DWT_LAR (*(volatile uint32_t *)0xE0001FB0u)
#define UNIQUE_ID ((volatile uint32_t *)0x1FF0F420u)
