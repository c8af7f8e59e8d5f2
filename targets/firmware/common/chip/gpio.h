// SPDX-License-Identifier: GPL-2.0-or-later
//
// Pins and their alternate functions (RM0008, section 9). The registers may be accessed as whole words only (9.2).

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t CR[2]; // CRL for pins 0 to 7, CRH for pins 8 to 15
    uint32_t IDR;
    uint32_t ODR;
    uint32_t BSRR;
    uint32_t BRR;
    uint32_t LCKR;
} gpio_t;

#define GPIOA ((volatile gpio_t *)0x40010800u)
#define GPIOB ((volatile gpio_t *)0x40010C00u)
#define GPIOC ((volatile gpio_t *)0x40011000u)

// The four bits CNF[1:0] MODE[1:0] of a pin (tables 20 and 21). Outputs here are always the fast ones, 50 MHz.
enum pin_mode {
    PIN_ANALOG = 0x0,
    PIN_FLOATING = 0x4,
    PIN_PULLED = 0x8, // up if the pin's bit in ODR is 1, down if it is 0
    PIN_OUTPUT = 0x3,
    PIN_OUTPUT_OPEN_DRAIN = 0x7,
    PIN_ALTERNATE = 0xB,
    PIN_ALTERNATE_OPEN_DRAIN = 0xF,
};

#define GPIO_LCKR_LCKK (1u << 16)

typedef struct {
    uint32_t EVCR;
    uint32_t MAPR;
    uint32_t EXTICR[4];
    uint32_t reserved;
    uint32_t MAPR2;
} afio_t;

#define AFIO ((volatile afio_t *)0x40010000u)

// SWJ_CFG: write-only, so a write to MAPR always has to name it (9.4.2)
#define AFIO_MAPR_SWJ_SHIFT 24
#define AFIO_MAPR_SWD_ONLY (2u << AFIO_MAPR_SWJ_SHIFT)
#define AFIO_MAPR_TIM3_SHIFT 10
#define AFIO_MAPR_USART1 (1u << 2)
