// SPDX-License-Identifier: GPL-2.0-or-later
//
// Serial peripheral interfaces (RM0008, section 25), with their gates (7.3.7, 7.3.8) and DMA channels (table 78).

#pragma once

#include <stdint.h>

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
#define SPI2 ((volatile spi_t *)0x40003800u)

#define RCC_APB2_SPI1 (1u << 12)
#define RCC_APB1_SPI2 (1u << 14)
#define DMA_SPI1_RX 2
#define DMA_SPI1_TX 3

#define SPI_CR1_CPHA (1u << 0)
#define SPI_CR1_CPOL (1u << 1)
#define SPI_CR1_MSTR (1u << 2)
#define SPI_CR1_BR_SHIFT 3
#define SPI_CR1_SPE (1u << 6)
#define SPI_CR1_LSBFIRST (1u << 7)
#define SPI_CR1_SSI (1u << 8)
#define SPI_CR1_SSM (1u << 9)
#define SPI_CR1_RXONLY (1u << 10)
#define SPI_CR1_DFF (1u << 11)
#define SPI_CR1_CRCNEXT (1u << 12)
#define SPI_CR1_CRCEN (1u << 13)
#define SPI_CR1_BIDIOE (1u << 14)
#define SPI_CR1_BIDIMODE (1u << 15)

#define SPI_CR2_RXDMAEN (1u << 0)
#define SPI_CR2_TXDMAEN (1u << 1)
#define SPI_CR2_SSOE (1u << 2)
#define SPI_CR2_ERRIE (1u << 5)
#define SPI_CR2_RXNEIE (1u << 6)
#define SPI_CR2_TXEIE (1u << 7)

#define SPI_SR_RXNE (1u << 0)
#define SPI_SR_TXE (1u << 1)
#define SPI_SR_CRCERR (1u << 4)
#define SPI_SR_MODF (1u << 5)
#define SPI_SR_OVR (1u << 6)
#define SPI_SR_BSY (1u << 7)
