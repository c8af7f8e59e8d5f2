// SPDX-License-Identifier: GPL-2.0-or-later
//
// Serial peripheral interfaces that move packets (RM0433, section 50.11).

#pragma once

#include "h753/blocks.h"

typedef struct {
    uint32_t CR1;
    uint32_t CR2;
    uint32_t CFG1;
    uint32_t CFG2;
    uint32_t IER;
    uint32_t SR;
    uint32_t IFCR;
    uint32_t reserved0;
    uint32_t TXDR;
    uint32_t reserved1[3];
    uint32_t RXDR;
    uint32_t reserved2[3];
    uint32_t CRCPOLY;
    uint32_t TXCRC;
    uint32_t RXCRC;
    uint32_t UDRDR;
} spi_t;

#define SPI1 ((volatile spi_t *)0x40013000u)
#define SPI1_TXDR8 (*(volatile uint8_t *)0x40013020u)
#define SPI1_TXDR16 (*(volatile uint16_t *)0x40013020u)
#define SPI1_RXDR8 (*(volatile uint8_t *)0x40013030u)
#define SPI1_RXDR16 (*(volatile uint16_t *)0x40013030u)

#define RCC_APB2_SPI1 (1u << 12)
#define RCC_SPI123_PER (4u << 12) // of D2CCIP1R: per_ck, which is HSI after a reset, at 64 MHz

enum { SPI1_IRQ = 35, AF_SPI1 = 5, NSS = 4, SCK = 5, MISO = 6, MOSI = 7 };
enum { REQUEST_SPI1_RX = 37, REQUEST_SPI1_TX = 38 };

enum {
    SPE = 1u << 0,
    MASRX = 1u << 8,
    CSTART = 1u << 9,
    CSUSP = 1u << 10,
    SSI = 1u << 12,
    TCRCINI = 1u << 15,
    RXDMAEN = 1u << 14, // of CFG1
    TXDMAEN = 1u << 15,
    CRCEN = 1u << 22,
    SIMPLEX_TX = 1u << 17, // of CFG2
    SIMPLEX_RX = 2u << 17,
    MASTER = 1u << 22,
    LSBFRST = 1u << 23,
    CPOL = 1u << 25,
    SSM = 1u << 26,
    SSIOP = 1u << 28,
    SSOE = 1u << 29,
    SSOM = 1u << 30,
    AFCNTR = 1u << 31,
};
#define DSIZE(bits) ((uint32_t)((bits)-1))
#define FTHLV(words) ((uint32_t)((words)-1) << 5)
#define CRCSIZE(bits) ((uint32_t)((bits)-1) << 16)
#define MBR(field) ((uint32_t)(field) << 28)
#define MSSI(clocks) ((uint32_t)(clocks))
#define MIDI(clocks) ((uint32_t)(clocks) << 4)

enum {
    RXP = 1u << 0,
    TXP = 1u << 1,
    DXP = 1u << 2,
    EOT = 1u << 3,
    TXTF = 1u << 4,
    OVR = 1u << 6,
    CRCE = 1u << 7,
    MODF = 1u << 9,
    TSERF = 1u << 10,
    SUSP = 1u << 11,
    TXC = 1u << 12,
    RXWNE = 1u << 15,
    FLAGS = 0x1FFFu,
    CLEAR_ALL = 0xFF8u,
};
#define RXPLVL(words) ((uint32_t)(words) << 13)
