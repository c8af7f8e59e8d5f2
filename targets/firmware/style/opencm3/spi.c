// SPDX-License-Identifier: GPL-2.0-or-later
//
// A master (RM0008, section 25). Exchanging a word waits for what comes in, not for TXE.

#include "opencm3.h"

void spi_init_master(volatile spi_t *spi, uint32_t baud, uint32_t polarity, uint32_t phase, uint32_t dff, uint32_t order)
{
    uint32_t control = spi->CR1 & (SPI_CR1_SPE | SPI_CR1_CRCEN | SPI_CR1_CRCNEXT);
    control |= SPI_CR1_MSTR | baud << SPI_CR1_BR_SHIFT | polarity | phase | dff | order;
    spi->CR2 |= SPI_CR2_SSOE;
    spi->CR1 = control;
}

void spi_enable_software_slave_management(volatile spi_t *spi) { spi->CR1 |= SPI_CR1_SSM; }

void spi_set_nss_high(volatile spi_t *spi) { spi->CR1 |= SPI_CR1_SSI; }

void spi_enable(volatile spi_t *spi) { spi->CR1 |= SPI_CR1_SPE; }

void spi_send(volatile spi_t *spi, uint16_t data)
{
    while (!(spi->SR & SPI_SR_TXE)) {
    }
    spi->DR = data;
}

uint16_t spi_read(volatile spi_t *spi)
{
    while (!(spi->SR & SPI_SR_RXNE)) {
    }
    return (uint16_t)spi->DR;
}

uint16_t spi_xfer(volatile spi_t *spi, uint16_t data)
{
    spi->DR = data;
    while (!(spi->SR & SPI_SR_RXNE)) {
    }
    return (uint16_t)spi->DR;
}

// RM0008, 25.3.8: what has come in, then TXE, then not BSY.
uint16_t spi_clean_disable(volatile spi_t *spi)
{
    while (!(spi->SR & SPI_SR_RXNE)) {
    }
    uint16_t data = (uint16_t)spi->DR;
    while (!(spi->SR & SPI_SR_TXE)) {
    }
    while (spi->SR & SPI_SR_BSY) {
    }
    spi->CR1 &= ~SPI_CR1_SPE;
    return data;
}
