// SPDX-License-Identifier: GPL-2.0-or-later
//
// A sequence of channels by DMA, as often as is asked for (RM0008, section 11). The converter is on while it works.

#include "chip/adc.h"

#include "chip/stm32f103.h"
#include "cycles.h"
#include "device.h"

#define LIMIT_MS 50

static struct sem lock, done;

static void dma_isr(const void *argument)
{
    (void)argument;
    DMA1->IFCR = DMA_GIF(DMA_ADC1);
    ADC1->CR2 &= ~(ADC_CR2_CONT | ADC_CR2_DMA | ADC_CR2_ADON);
    DMA1_CHANNEL(DMA_ADC1)->CCR = 0;
    sem_give(&done);
}

static uint32_t set_sequence(uint32_t channels)
{
    uint32_t words[3] = {0}, count = 0;
    for (uint32_t channel = 0; channel < 18; ++channel)
        if (channels & 1u << channel) {
            words[count / 6] |= channel << 5 * (count % 6);
            ++count;
        }
    ADC1->SQR3 = words[0];
    ADC1->SQR2 = words[1];
    ADC1->SQR1 = words[2] | (count - 1) << 20;
    return count;
}

static void calibrate(void)
{
    ADC1->CR2 |= ADC_CR2_RSTCAL;
    while (ADC1->CR2 & ADC_CR2_RSTCAL) {
    }
    ADC1->CR2 |= ADC_CR2_CAL;
    while (ADC1->CR2 & ADC_CR2_CAL) {
    }
}

static int read(const struct device *device, const struct adc_sequence *sequence)
{
    (void)device;
    sem_take(&lock, FOREVER);
    uint32_t count = set_sequence(sequence->channels) * sequence->samplings;
    ADC1->CR2 |= ADC_CR2_ADON;
    wait_cycles(72 * 2);
    if (sequence->calibrate)
        calibrate();
    DMA1_CHANNEL(DMA_ADC1)->CPAR = (uint32_t)(uintptr_t)&ADC1->DR;
    DMA1_CHANNEL(DMA_ADC1)->CMAR = (uint32_t)(uintptr_t)sequence->buffer;
    DMA1_CHANNEL(DMA_ADC1)->CNDTR = count;
    DMA1_CHANNEL(DMA_ADC1)->CCR =
        DMA_CCR_MINC | DMA_CCR_TCIE | 1u << DMA_CCR_PSIZE_SHIFT | 1u << DMA_CCR_MSIZE_SHIFT | DMA_CCR_EN;
    ADC1->CR2 |= ADC_CR2_DMA | (sequence->samplings > 1 ? ADC_CR2_CONT : 0);
    ADC1->CR2 |= ADC_CR2_SWSTART;
    int result = sem_take(&done, LIMIT_MS);
    sem_give(&lock);
    return result;
}

const struct adc_api adc_stm32 = {read};

int adc_stm32_init(const struct device *device)
{
    (void)device;
    RCC->CFGR |= 2u << RCC_CFGR_ADCPRE_SHIFT; // 12 MHz
    RCC->AHBENR |= RCC_AHB_DMA1;
    RCC->APB2ENR |= RCC_APB2_ADC1;
    lock = SEM(1, 1);
    done = SEM(0, 1);
    ADC1->CR1 = ADC_CR1_SCAN;
    ADC1->CR2 = ADC_CR2_TSVREFE | ADC_CR2_EXTTRIG | ADC_BY_SOFTWARE << ADC_CR2_EXTSEL_SHIFT;
    ADC1->SMPR1 = 7u << 18 | 7u << 21; // 239.5 clocks for sensor and reference
    ADC1->SMPR2 = 3u | 3u << 3;        // 28.5 for PA0 and PA1
    irq_connect(DMA1_CHANNEL1_IRQ + DMA_ADC1 - 1, dma_isr, 0);
    return 0;
}
