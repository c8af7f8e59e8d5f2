// SPDX-License-Identifier: GPL-2.0-or-later
//
// Serial ports (RM0433, section 48.7).

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t CR1;
    uint32_t CR2;
    uint32_t CR3;
    uint32_t BRR;
    uint32_t GTPR;
    uint32_t RTOR;
    uint32_t RQR;
    uint32_t ISR;
    uint32_t ICR;
    uint32_t RDR;
    uint32_t TDR;
    uint32_t PRESC;
} usart_t;

#define USART2 ((volatile usart_t *)0x40004400u)
#define USART3 ((volatile usart_t *)0x40004800u)

#define USART_CR1_UE (1u << 0)
#define USART_CR1_RE (1u << 2)
#define USART_CR1_TE (1u << 3)
#define USART_CR1_IDLEIE (1u << 4)

#define USART_CR3_EIE (1u << 0)
#define USART_CR3_DMAR (1u << 6)
#define USART_CR3_DMAT (1u << 7)

#define USART_FE (1u << 1) // bits of ISR; ICR has those that can be cleared at the same places
#define USART_NE (1u << 2)
#define USART_ORE (1u << 3)
#define USART_IDLE (1u << 4)
#define USART_ERRORS (USART_FE | USART_NE | USART_ORE)
