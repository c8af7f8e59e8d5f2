// SPDX-License-Identifier: GPL-2.0-or-later
//
// The low-power timer, the same block in STM32F7 and STM32H7 (RM0410 section 26.7, RM0433 section 43.7), and the part of
// its self-test that both have.

#pragma once

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint32_t ISR;
    uint32_t ICR;
    uint32_t IER;
    uint32_t CFGR;
    uint32_t CR;
    uint32_t CMP;
    uint32_t ARR;
    uint32_t CNT;
    uint32_t reserved;
    uint32_t CFGR2; // of the H7
} lptim_t;

// Flags, their interrupts, and what clears them.
enum {
    LPTIM_CMPM = 1u << 0,
    LPTIM_ARRM = 1u << 1,
    LPTIM_EXTTRIG = 1u << 2,
    LPTIM_CMPOK = 1u << 3,
    LPTIM_ARROK = 1u << 4,
    LPTIM_UP = 1u << 5,
    LPTIM_DOWN = 1u << 6,
    LPTIM_ALL = 0x7Fu,
};
enum {
    LPTIM_CKSEL = 1u << 0,
    LPTIM_CKPOL_FALLING = 1u << 1,
    LPTIM_CKPOL_BOTH = 2u << 1,
    LPTIM_CKFLT_8 = 3u << 3,
    LPTIM_PRESC_SHIFT = 9,
    LPTIM_TRIGEN_RISING = 1u << 17,
    LPTIM_TIMOUT = 1u << 19,
    LPTIM_WAVE = 1u << 20,
    LPTIM_WAVPOL = 1u << 21,
    LPTIM_PRELOAD = 1u << 22,
    LPTIM_COUNTMODE = 1u << 23,
    LPTIM_ENC = 1u << 24,
};
enum {
    LPTIM_ENABLE = 1u << 0,
    LPTIM_SNGSTRT = 1u << 1,
    LPTIM_CNTSTRT = 1u << 2,
    LPTIM_COUNTRST = 1u << 3, // these two of the H7
    LPTIM_RSTARE = 1u << 4,
};

#define LPTIM_CFGR_PRESC(shift) ((uint32_t)(shift) << LPTIM_PRESC_SHIFT)

#define LPTIM1 ((volatile lptim_t *)0x40002400u) // on both chips

// --- what the chip gives to the common part: LPTIM1 and its pins, on PCLK1, which is HCLK

enum lptim_input { LPTIM_IN1, LPTIM_IN2, LPTIM_ETR };

void lptim_pull(enum lptim_input input, bool high); // moves an input by its own pull
bool lptim_out(void);                               // the level of the output's pin
void lptim_reset(void);                             // by RCC
bool lptim_pending(void);                           // its interrupt, in the NVIC
void lptim_forget(void);

// Checks all that both chips have.
void lptim_check_block(void);

// Sets a timer up from reset: enabled, with both values, and no flag but those that they cause.
void lptim_open(volatile lptim_t *timer, uint32_t settings, uint32_t interrupts, uint32_t reload, uint32_t compare);
