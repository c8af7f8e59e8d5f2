// SPDX-License-Identifier: GPL-2.0-or-later
//
// Registers of the Cortex-M3 itself, which every chip with this core has at these addresses.
// Sources: ARMv7-M Architecture Reference Manual (ARM DDI 0403), part B and C; ST PM0056, section 4.

#pragma once

#include <stdint.h>

// --- System control block (DDI 0403, B3.2)

typedef struct {
    uint32_t CPUID;
    uint32_t ICSR;
    uint32_t VTOR;
    uint32_t AIRCR;
    uint32_t SCR;
    uint32_t CCR;
    uint8_t SHPR[12]; // priority of exceptions 4 to 15
    uint32_t SHCSR;
    uint32_t CFSR;
    uint32_t HFSR;
    uint32_t DFSR;
    uint32_t MMFAR;
    uint32_t BFAR;
    uint32_t AFSR;
} scb_t;

#define SCB ((volatile scb_t *)0xE000ED00u)

#define ICTR (*(volatile uint32_t *)0xE000E004u)  // interrupt controller type
#define ACTLR (*(volatile uint32_t *)0xE000E008u) // auxiliary control (Cortex-M3 TRM)
#define STIR (*(volatile uint32_t *)0xE000EF00u)  // software triggered interrupt

#define ACTLR_DISDEFWBUF (1u << 1)

#define ICSR_VECTACTIVE 0x1FFu
#define ICSR_RETTOBASE (1u << 11)
#define ICSR_VECTPENDING_SHIFT 12
#define ICSR_ISRPENDING (1u << 22)
#define ICSR_PENDSTCLR (1u << 25)
#define ICSR_PENDSTSET (1u << 26)
#define ICSR_PENDSVCLR (1u << 27)
#define ICSR_PENDSVSET (1u << 28)
#define ICSR_NMIPENDSET (1u << 31)

#define AIRCR_VECTKEY (0x05FAu << 16)
#define AIRCR_PRIGROUP_SHIFT 8
#define AIRCR_SYSRESETREQ (1u << 2)

#define SCR_SLEEPONEXIT (1u << 1)
#define SCR_SLEEPDEEP (1u << 2)
#define SCR_SEVONPEND (1u << 4)

#define CCR_USERSETMPEND (1u << 1)
#define CCR_UNALIGN_TRP (1u << 3)
#define CCR_DIV_0_TRP (1u << 4)
#define CCR_STKALIGN (1u << 9)

#define SHCSR_MEMFAULTENA (1u << 16)
#define SHCSR_BUSFAULTENA (1u << 17)
#define SHCSR_USGFAULTENA (1u << 18)

#define CFSR_IACCVIOL (1u << 0)
#define CFSR_IBUSERR (1u << 8)
#define CFSR_PRECISERR (1u << 9)
#define CFSR_IMPRECISERR (1u << 10)
#define CFSR_BFARVALID (1u << 15)
#define CFSR_UNDEFINSTR (1u << 16)
#define CFSR_INVSTATE (1u << 17)
#define CFSR_INVPC (1u << 18)
#define CFSR_NOCP (1u << 19)
#define CFSR_UNALIGNED (1u << 24)
#define CFSR_DIVBYZERO (1u << 25)

#define HFSR_VECTTBL (1u << 1)
#define HFSR_FORCED (1u << 30)

// --- Nested vectored interrupt controller (DDI 0403, B3.4)

typedef struct {
    uint32_t ISER[8];
    uint32_t reserved0[24];
    uint32_t ICER[8];
    uint32_t reserved1[24];
    uint32_t ISPR[8];
    uint32_t reserved2[24];
    uint32_t ICPR[8];
    uint32_t reserved3[24];
    uint32_t IABR[8];
    uint32_t reserved4[56];
    uint8_t IPR[240];
} nvic_t;

#define NVIC ((volatile nvic_t *)0xE000E100u)

// --- SysTick (DDI 0403, B3.3)

typedef struct {
    uint32_t CTRL;
    uint32_t LOAD;
    uint32_t VAL;
    uint32_t CALIB;
} systick_t;

#define SYSTICK ((volatile systick_t *)0xE000E010u)

#define SYSTICK_ENABLE (1u << 0)
#define SYSTICK_TICKINT (1u << 1)
#define SYSTICK_CLKSOURCE (1u << 2) // 1: HCLK; 0: HCLK / 8 on this chip (RM0008, 10.1.2)
#define SYSTICK_COUNTFLAG (1u << 16)

// --- Debug: DEMCR, DWT, ITM (DDI 0403, C1)

#define DHCSR (*(volatile uint32_t *)0xE000EDF0u)
#define DEMCR (*(volatile uint32_t *)0xE000EDFCu)
#define DEMCR_TRCENA (1u << 24)

typedef struct {
    uint32_t CTRL;
    uint32_t CYCCNT;
    uint32_t CPICNT;
    uint32_t EXCCNT;
    uint32_t SLEEPCNT;
    uint32_t LSUCNT;
    uint32_t FOLDCNT;
    uint32_t PCSR;
} dwt_t;

#define DWT ((volatile dwt_t *)0xE0001000u)

#define DWT_CYCCNTENA (1u << 0)
#define DWT_NUMCOMP_SHIFT 28

typedef struct {
    union {
        uint32_t word;
        uint16_t half;
        uint8_t byte;
    } STIM[256];
    uint32_t reserved0[640];
    uint32_t TER[8];
    uint32_t reserved1[8];
    uint32_t TPR;
    uint32_t reserved2[15];
    uint32_t TCR;
    uint32_t reserved3[75];
    uint32_t LAR;
    uint32_t LSR;
} itm_t;

#define ITM ((volatile itm_t *)0xE0000000u)

#define ITM_TCR_ITMENA (1u << 0)
#define CORESIGHT_UNLOCK 0xC5ACCE55u

_Static_assert(__builtin_offsetof(nvic_t, IPR) == 0x300, "NVIC layout");
_Static_assert(__builtin_offsetof(itm_t, TER) == 0xE00, "ITM layout");
_Static_assert(__builtin_offsetof(itm_t, TPR) == 0xE40, "ITM layout");
_Static_assert(__builtin_offsetof(itm_t, TCR) == 0xE80, "ITM layout");
_Static_assert(__builtin_offsetof(itm_t, LAR) == 0xFB0, "ITM layout");
