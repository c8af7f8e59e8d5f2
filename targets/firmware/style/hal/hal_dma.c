// SPDX-License-Identifier: GPL-2.0-or-later

#include "hal_buses.h"

void hal_dma_start_it(hal_dma_t *dma, volatile uint32_t *peripheral, volatile void *memory, uint32_t count)
{
    volatile dma_channel_t *channel = DMA1_CHANNEL(dma->channel);
    channel->CCR = dma->settings;
    DMA1->IFCR = DMA_GIF(dma->channel);
    channel->CNDTR = count;
    channel->CPAR = (uint32_t)(uintptr_t)peripheral;
    channel->CMAR = (uint32_t)(uintptr_t)memory;
    channel->CCR |= DMA_CCR_TCIE | DMA_CCR_TEIE;
    channel->CCR |= DMA_CCR_EN;
}

void hal_dma_irq_handler(hal_dma_t *dma)
{
    if (!(DMA1->ISR & DMA_TCIF(dma->channel)))
        return;
    DMA1_CHANNEL(dma->channel)->CCR &= ~(DMA_CCR_TCIE | DMA_CCR_TEIE);
    DMA1->IFCR = DMA_TCIF(dma->channel);
    if (dma->complete)
        dma->complete(dma);
}
