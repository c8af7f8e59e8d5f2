// SPDX-License-Identifier: GPL-2.0-or-later
//
// Real-time clock (RM0008, section 18).

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t CRH;
    uint32_t CRL;
    uint32_t PRLH;
    uint32_t PRLL;
    uint32_t DIVH;
    uint32_t DIVL;
    uint32_t CNTH;
    uint32_t CNTL;
    uint32_t ALRH;
    uint32_t ALRL;
} rtc_t;

#define RTC ((volatile rtc_t *)0x40002800u)

#define RTC_CRL_SECF (1u << 0)
#define RTC_CRL_ALRF (1u << 1)
#define RTC_CRL_OWF (1u << 2)
#define RTC_CRL_RSF (1u << 3)
#define RTC_CRL_CNF (1u << 4)
#define RTC_CRL_RTOFF (1u << 5)

#define RCC_BDCR_RTC_LSE (1u << 8)
#define RCC_BDCR_RTC_LSI (2u << 8)
#define RCC_BDCR_RTC_ON (1u << 15)
#define RTC_ALARM_LINE 17
