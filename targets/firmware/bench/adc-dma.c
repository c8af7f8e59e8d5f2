// SPDX-License-Identifier: GPL-2.0-or-later
//
// What an oscilloscope does: ADC1 converts PA0 as fast as it can at 72 MHz, 857 kHz, and DMA keeps a ring of 1024 values.
// PA2 toggles with each half of it; the program sleeps meanwhile. `halves` counts them, `lost` those that were too late.

#include "chip/adc.h"
#include "chip/dma.h"
#include "chip/stm32f103.h"
#include "clock.h"
#include "handlers.h"
#include "pin.h"

#define COUNT 1024u

static volatile uint16_t ring[COUNT];
volatile uint32_t halves, lost;

void DMA1_Channel1_IRQHandler(void)
{
    uint32_t flags = DMA1->ISR;
    DMA1->IFCR = 0xFu;
    if ((flags & 6u) == 6u)
        ++lost;
    ++halves;
    pin_toggle(GPIOA, 2);
}

int main(void)
{
    clock_72mhz();
    RCC->CFGR |= 2u << RCC_CFGR_ADCPRE_SHIFT; // 12 MHz
    RCC->AHBENR |= RCC_AHB_DMA1;
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_ADC1;
    pin_mode(GPIOA, 0, PIN_ANALOG);
    pin_mode(GPIOA, 2, PIN_OUTPUT);
    volatile dma_channel_t *channel = &DMA1->CHANNEL[DMA_ADC1 - 1];
    channel->CPAR = (uint32_t)(uintptr_t)&ADC1->DR;
    channel->CMAR = (uint32_t)(uintptr_t)ring;
    channel->CNDTR = COUNT;
    channel->CCR = DMA_CCR_MINC | DMA_CCR_CIRC | 1u << DMA_CCR_PSIZE_SHIFT | 1u << DMA_CCR_MSIZE_SHIFT | DMA_CCR_TCIE |
                   DMA_CCR_HTIE | DMA_CCR_EN;
    irq_line_enable(DMA1_CHANNEL1_IRQ);
    ADC1->CR2 = ADC_CR2_ADON;
    for (int wait = 0; wait < 100; ++wait)
        __asm__ volatile("nop");
    ADC1->CR2 = ADC_CR2_ADON | ADC_CR2_CONT | ADC_CR2_DMA | ADC_BY_SOFTWARE << ADC_CR2_EXTSEL_SHIFT | ADC_CR2_EXTTRIG;
    ADC1->CR2 |= ADC_CR2_SWSTART;
    for (;;)
        WFI();
}
