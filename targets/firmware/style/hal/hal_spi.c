// SPDX-License-Identifier: GPL-2.0-or-later
//
// A master (RM0008, section 25). Both ways at once TXE and RXNE take turns; one way out leaves an overrun behind, which is cleared.

#include "hal_buses.h"

hal_status_t hal_spi_init(hal_spi_t *spi)
{
    volatile spi_t *unit = spi->instance;
    unit->CR1 &= ~SPI_CR1_SPE;
    unit->CR1 = SPI_CR1_MSTR | SPI_CR1_SSM | SPI_CR1_SSI | spi->divider << SPI_CR1_BR_SHIFT;
    unit->CR2 = 0;
    spi->state = HAL_STATE_READY;
    return HAL_OK;
}

static void enable(hal_spi_t *spi)
{
    if (!(spi->instance->CR1 & SPI_CR1_SPE))
        spi->instance->CR1 |= SPI_CR1_SPE;
}

static hal_status_t finish(hal_spi_t *spi, hal_status_t status, uint32_t start, uint32_t timeout_ms)
{
    while (status == HAL_OK && spi->instance->SR & SPI_SR_BSY)
        if (hal_get_tick() - start >= timeout_ms)
            status = HAL_TIMEOUT;
    spi->state = HAL_STATE_READY;
    return status;
}

hal_status_t hal_spi_transmit(hal_spi_t *spi, const uint8_t *data, size_t size, uint32_t timeout_ms)
{
    if (spi->state != HAL_STATE_READY)
        return HAL_BUSY;
    spi->state = HAL_STATE_BUSY;
    enable(spi);
    uint32_t start = hal_get_tick();
    hal_status_t status = HAL_OK;
    while (size && status == HAL_OK)
        if (spi->instance->SR & SPI_SR_TXE) {
            spi->instance->DR = *data++;
            --size;
        } else if (hal_get_tick() - start >= timeout_ms) {
            status = HAL_TIMEOUT;
        }
    while (status == HAL_OK && !(spi->instance->SR & SPI_SR_TXE)) {
    }
    status = finish(spi, status, start, timeout_ms);
    (void)spi->instance->DR;
    (void)spi->instance->SR;
    return status;
}

hal_status_t hal_spi_transmit_receive(hal_spi_t *spi, const uint8_t *out, uint8_t *in, size_t size, uint32_t timeout_ms)
{
    if (spi->state != HAL_STATE_READY)
        return HAL_BUSY;
    spi->state = HAL_STATE_BUSY;
    enable(spi);
    uint32_t start = hal_get_tick();
    bool may_send = true;
    size_t to_send = size, to_receive = size;
    hal_status_t status = HAL_OK;
    while ((to_send || to_receive) && status == HAL_OK) {
        if (may_send && to_send && spi->instance->SR & SPI_SR_TXE) {
            spi->instance->DR = *out++;
            --to_send;
            may_send = false;
        }
        if (to_receive && spi->instance->SR & SPI_SR_RXNE) {
            *in++ = (uint8_t)spi->instance->DR;
            --to_receive;
            may_send = true;
        }
        if (hal_get_tick() - start >= timeout_ms)
            status = HAL_TIMEOUT;
    }
    return finish(spi, status, start, timeout_ms);
}

// A master that only receives sends what stands in the buffer.
hal_status_t hal_spi_receive(hal_spi_t *spi, uint8_t *data, size_t size, uint32_t timeout_ms)
{
    return hal_spi_transmit_receive(spi, data, data, size, timeout_ms);
}

static void dma_complete(hal_dma_t *dma)
{
    hal_spi_t *spi = dma->parent;
    spi->instance->CR2 &= ~(SPI_CR2_TXDMAEN | SPI_CR2_RXDMAEN);
    finish(spi, HAL_OK, hal_get_tick(), HAL_FOREVER);
}

hal_status_t hal_spi_transmit_receive_dma(hal_spi_t *spi, const uint8_t *out, uint8_t *in, size_t size)
{
    if (spi->state != HAL_STATE_READY)
        return HAL_BUSY;
    spi->state = HAL_STATE_BUSY;
    spi->rx_dma->complete = dma_complete;
    spi->rx_dma->parent = spi;
    hal_dma_start_it(spi->rx_dma, &spi->instance->DR, in, size);
    spi->instance->CR2 |= SPI_CR2_RXDMAEN;
    hal_dma_start_it(spi->tx_dma, &spi->instance->DR, (void *)(uintptr_t)out, size);
    enable(spi);
    spi->instance->CR2 |= SPI_CR2_TXDMAEN;
    return HAL_OK;
}
