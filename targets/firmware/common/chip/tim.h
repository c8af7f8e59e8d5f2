// SPDX-License-Identifier: GPL-2.0-or-later
//
// Timers: TIM1 (RM0008, section 14) and the general-purpose TIM2 to TIM4 (section 15), which lack RCR and BDTR.

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t CR1;
    uint32_t CR2;
    uint32_t SMCR;
    uint32_t DIER;
    uint32_t SR;
    uint32_t EGR;
    uint32_t CCMR1;
    uint32_t CCMR2;
    uint32_t CCER;
    uint32_t CNT;
    uint32_t PSC;
    uint32_t ARR;
    uint32_t RCR;
    uint32_t CCR[4]; // CCR[n - 1] is CCRn
    uint32_t BDTR;
    uint32_t DCR;
    uint32_t DMAR;
} tim_t;

#define TIM1 ((volatile tim_t *)0x40012C00u)
#define TIM2 ((volatile tim_t *)0x40000000u)
#define TIM3 ((volatile tim_t *)0x40000400u)
#define TIM4 ((volatile tim_t *)0x40000800u)

#define TIM_CR1_CEN (1u << 0)
#define TIM_CR1_UDIS (1u << 1)
#define TIM_CR1_URS (1u << 2)
#define TIM_CR1_OPM (1u << 3)
#define TIM_CR1_DIR (1u << 4)
#define TIM_CR1_CMS_SHIFT 5
#define TIM_CR1_ARPE (1u << 7)
#define TIM_CR1_CKD_SHIFT 8

#define TIM_CR2_CCPC (1u << 0)
#define TIM_CR2_CCUS (1u << 2)
#define TIM_CR2_MMS_SHIFT 4
#define TIM_CR2_OIS1 (1u << 8)
#define TIM_CR2_OIS1N (1u << 9)

// MMS
#define TIM_TRGO_RESET 0u
#define TIM_TRGO_ENABLE 1u
#define TIM_TRGO_UPDATE 2u
#define TIM_TRGO_OC1REF 4u

#define TIM_SMCR_TS_SHIFT 4
#define TIM_SMCR_MSM (1u << 7)
#define TIM_SMCR_ECE (1u << 14)
#define TIM_SMCR_ETP (1u << 15)

// SMS
#define TIM_SLAVE_ENCODER1 1u
#define TIM_SLAVE_ENCODER2 2u
#define TIM_SLAVE_ENCODER3 3u
#define TIM_SLAVE_RESET 4u
#define TIM_SLAVE_GATED 5u
#define TIM_SLAVE_TRIGGER 6u
#define TIM_SLAVE_EXTERNAL 7u

// TS, shifted into place
#define TIM_TS_ITR(n) ((uint32_t)(n) << TIM_SMCR_TS_SHIFT)
#define TIM_TS_TI1F_ED (4u << TIM_SMCR_TS_SHIFT)
#define TIM_TS_TI1FP1 (5u << TIM_SMCR_TS_SHIFT)
#define TIM_TS_TI2FP2 (6u << TIM_SMCR_TS_SHIFT)

#define TIM_UIF (1u << 0) // bits of SR; DIER and EGR have theirs at the same places
#define TIM_CCIF(n) (1u << (n))
#define TIM_COMIF (1u << 5)
#define TIM_TIF (1u << 6)
#define TIM_BIF (1u << 7)
#define TIM_CCOF(n) (1u << ((n) + 8))
#define TIM_DIER_UDE (1u << 8)
#define TIM_DIER_CCDE(n) (1u << ((n) + 8))

#define TIM_EGR_UG (1u << 0)
#define TIM_EGR_COMG (1u << 5)
#define TIM_EGR_TG (1u << 6)
#define TIM_EGR_BG (1u << 7)

// The eight bits that CCMR1 and CCMR2 give to a channel; the even channel's are shifted by 8
#define TIM_CC_INPUT_DIRECT 1u
#define TIM_CC_INPUT_OTHER 2u
#define TIM_CC_INPUT_TRC 3u
#define TIM_IC_PSC_SHIFT 2
#define TIM_IC_FILTER_SHIFT 4
#define TIM_OC_PRELOAD (1u << 3)
#define TIM_OC_FROZEN (0u << 4)
#define TIM_OC_ACTIVE (1u << 4)
#define TIM_OC_INACTIVE (2u << 4)
#define TIM_OC_TOGGLE (3u << 4)
#define TIM_OC_FORCE_LOW (4u << 4)
#define TIM_OC_FORCE_HIGH (5u << 4)
#define TIM_OC_PWM1 (6u << 4)
#define TIM_OC_PWM2 (7u << 4)

#define TIM_CCER_E(n) (1u << (4 * ((n) - 1)))
#define TIM_CCER_P(n) (2u << (4 * ((n) - 1)))
#define TIM_CCER_NE(n) (4u << (4 * ((n) - 1)))
#define TIM_CCER_NP(n) (8u << (4 * ((n) - 1)))

#define TIM_BDTR_LOCK_SHIFT 8
#define TIM_BDTR_OSSI (1u << 10)
#define TIM_BDTR_OSSR (1u << 11)
#define TIM_BDTR_BKE (1u << 12)
#define TIM_BDTR_BKP (1u << 13)
#define TIM_BDTR_AOE (1u << 14)
#define TIM_BDTR_MOE (1u << 15)
