// SPDX-License-Identifier: GPL-2.0-or-later
//
// Power control (RM0008, section 5) and the registers that the battery keeps (section 6).

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t CR;
    uint32_t CSR;
} pwr_t;

#define PWR ((volatile pwr_t *)0x40007000u)

#define PWR_CR_LPDS (1u << 0)
#define PWR_CR_PDDS (1u << 1)
#define PWR_CR_CWUF (1u << 2)
#define PWR_CR_CSBF (1u << 3)
#define PWR_CR_PVDE (1u << 4)
#define PWR_CR_PLS_SHIFT 5
#define PWR_CR_DBP (1u << 8)

#define PWR_CSR_WUF (1u << 0)
#define PWR_CSR_SBF (1u << 1)
#define PWR_CSR_PVDO (1u << 2)
#define PWR_CSR_EWUP (1u << 8)

typedef struct {
    uint32_t reserved;
    uint32_t DR[10]; // DR[n - 1] is DRn: sixteen bits
    uint32_t RTCCR;
    uint32_t CR;
    uint32_t CSR;
} bkp_t;

#define BKP ((volatile bkp_t *)0x40006C00u)
