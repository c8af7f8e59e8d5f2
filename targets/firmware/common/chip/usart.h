// SPDX-License-Identifier: GPL-2.0-or-later
//
// Serial ports (RM0008, section 27).

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t SR;
    uint32_t DR;
    uint32_t BRR;
    uint32_t CR1;
    uint32_t CR2;
    uint32_t CR3;
    uint32_t GTPR;
} usart_t;

#define USART1 ((volatile usart_t *)0x40013800u)
#define USART2 ((volatile usart_t *)0x40004400u)
#define USART3 ((volatile usart_t *)0x40004800u)

#define USART_SR_PE (1u << 0)
#define USART_SR_FE (1u << 1)
#define USART_SR_NE (1u << 2)
#define USART_SR_ORE (1u << 3)
#define USART_SR_IDLE (1u << 4)
#define USART_SR_RXNE (1u << 5)
#define USART_SR_TC (1u << 6)
#define USART_SR_TXE (1u << 7)
#define USART_SR_LBD (1u << 8)
#define USART_SR_CTS (1u << 9)

#define USART_CR1_SBK (1u << 0)
#define USART_CR1_RWU (1u << 1)
#define USART_CR1_RE (1u << 2)
#define USART_CR1_TE (1u << 3)
#define USART_CR1_IDLEIE (1u << 4)
#define USART_CR1_RXNEIE (1u << 5)
#define USART_CR1_TCIE (1u << 6)
#define USART_CR1_TXEIE (1u << 7)
#define USART_CR1_PEIE (1u << 8)
#define USART_CR1_PS (1u << 9)
#define USART_CR1_PCE (1u << 10)
#define USART_CR1_WAKE (1u << 11)
#define USART_CR1_M (1u << 12)
#define USART_CR1_UE (1u << 13)

#define USART_CR2_ADD 0xFu
#define USART_CR2_LBDL (1u << 5)
#define USART_CR2_LBDIE (1u << 6)
#define USART_CR2_STOP_SHIFT 12
#define USART_CR2_STOP_2 (2u << USART_CR2_STOP_SHIFT)
#define USART_CR2_LINEN (1u << 14)

#define USART_CR3_EIE (1u << 0)
#define USART_CR3_HDSEL (1u << 3)
#define USART_CR3_DMAR (1u << 6)
#define USART_CR3_DMAT (1u << 7)
#define USART_CR3_RTSE (1u << 8)
#define USART_CR3_CTSE (1u << 9)
#define USART_CR3_CTSIE (1u << 10)
