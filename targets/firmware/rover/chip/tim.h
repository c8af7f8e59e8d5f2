// SPDX-License-Identifier: GPL-2.0-or-later
//
// Timers (RM0410, sections 25 and 26): TIM1 with its complementary outputs, TIM2 and TIM5 of 32 bits.

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t CR1;
    uint32_t CR2;
    uint32_t SMCR;
    uint32_t DIER;
    uint32_t SR;
    uint32_t EGR;
    uint32_t CCMR[2];
    uint32_t CCER;
    uint32_t CNT;
    uint32_t PSC;
    uint32_t ARR;
    uint32_t RCR;
    uint32_t CCR[4]; // CCR[n - 1] is CCRn
    uint32_t BDTR;
} tim_t;

#define TIM1 ((volatile tim_t *)0x40010000u)
#define TIM2 ((volatile tim_t *)0x40000000u)
#define TIM5 ((volatile tim_t *)0x40000C00u)

#define TIM_CR1_CEN (1u << 0)
#define TIM_CR1_ARPE (1u << 7)
#define TIM_EGR_UG (1u << 0)

// The eight bits that CCMR gives to a channel; the even channel's are shifted by 8
#define TIM_OC_PRELOAD (1u << 3)
#define TIM_OC_PWM1 (6u << 4)

#define TIM_CCER_E(n) (1u << (4 * ((n) - 1)))
#define TIM_CCER_NE(n) (4u << (4 * ((n) - 1)))

#define TIM_BDTR_MOE (1u << 15)
