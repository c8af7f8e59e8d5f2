// SPDX-License-Identifier: GPL-2.0-or-later
//
// Serial peripheral interfaces with FIFOs (RM0410, section 35.9), and how a program gives them their interrupt.

#pragma once

#include "f767/transfers.h"

typedef struct {
    uint32_t CR1;
    uint32_t CR2;
    uint32_t SR;
    uint32_t DR;
    uint32_t CRCPR;
    uint32_t RXCRCR;
    uint32_t TXCRCR;
} spi_t;

#define SPI1 ((volatile spi_t *)0x40013000u)
// Accesses of 8 and 16 bits, which move one word or two where those are not wider than a byte.
#define SPI1_DR8 (*(volatile uint8_t *)0x4001300Cu)
#define SPI1_DR16 (*(volatile uint16_t *)0x4001300Cu)

#define RCC_APB2RSTR (*(volatile uint32_t *)0x40023824u)
#define RCC_APB2_SPI1 (1u << 12)

enum { SPI1_IRQ = 35, AF_SPI1 = 5, NSS = 4, SCK = 5, MISO = 6, MOSI = 7 };
enum { DMA_RX = 0, DMA_TX = 3, DMA_SPI1 = 3 }; // streams of DMA2, and their channel

enum {
    CR1_CPHA = 1u << 0,
    CR1_CPOL = 1u << 1,
    CR1_MSTR = 1u << 2,
    CR1_SPE = 1u << 6,
    CR1_LSBFIRST = 1u << 7,
    CR1_SSI = 1u << 8,
    CR1_SSM = 1u << 9,
    CR1_RXONLY = 1u << 10,
    CR1_CRCL = 1u << 11,
    CR1_CRCNEXT = 1u << 12,
    CR1_CRCEN = 1u << 13,
};
#define CR1_BR(field) ((uint32_t)(field) << 3)
enum {
    CR2_RXDMAEN = 1u << 0,
    CR2_TXDMAEN = 1u << 1,
    CR2_SSOE = 1u << 2,
    CR2_NSSP = 1u << 3,
    CR2_FRF = 1u << 4,
    CR2_RXNEIE = 1u << 6,
    CR2_TXEIE = 1u << 7,
    CR2_FRXTH = 1u << 12,
    CR2_LDMA_RX = 1u << 13,
    CR2_LDMA_TX = 1u << 14,
};
#define CR2_DS(bits) ((uint32_t)((bits)-1) << 8)
enum {
    SR_RXNE = 1u << 0,
    SR_TXE = 1u << 1,
    SR_CRCERR = 1u << 4,
    SR_MODF = 1u << 5,
    SR_OVR = 1u << 6,
    SR_BSY = 1u << 7,
};
#define SR_FRLVL(level) ((uint32_t)(level) << 9)
#define SR_FTLVL(level) ((uint32_t)(level) << 11)
