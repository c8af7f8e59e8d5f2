// SPDX-License-Identifier: GPL-2.0-or-later
//
// The converter (RM0008, section 11). A conversion is started by writing ADON once more, without a trigger.

#include "opencm3.h"

void adc_power_off(volatile adc_t *adc) { adc->CR2 &= ~ADC_CR2_ADON; }

void adc_power_on(volatile adc_t *adc)
{
    if (!(adc->CR2 & ADC_CR2_ADON)) // once more would start a conversion
        adc->CR2 |= ADC_CR2_ADON;
}

void adc_enable_scan_mode(volatile adc_t *adc) { adc->CR1 |= ADC_CR1_SCAN; }

void adc_disable_scan_mode(volatile adc_t *adc) { adc->CR1 &= ~ADC_CR1_SCAN; }

void adc_set_single_conversion_mode(volatile adc_t *adc) { adc->CR2 &= ~ADC_CR2_CONT; }

void adc_disable_external_trigger_regular(volatile adc_t *adc) { adc->CR2 &= ~ADC_CR2_EXTTRIG; }

void adc_enable_external_trigger_injected(volatile adc_t *adc, uint32_t source)
{
    adc->CR2 = (adc->CR2 & ~(7u << ADC_CR2_JEXTSEL_SHIFT)) | source << ADC_CR2_JEXTSEL_SHIFT | ADC_CR2_JEXTTRIG;
}

void adc_set_right_aligned(volatile adc_t *adc) { adc->CR2 &= ~ADC_CR2_ALIGN; }

void adc_enable_temperature_sensor(volatile adc_t *adc) { adc->CR2 |= ADC_CR2_TSVREFE; }

void adc_set_sample_time_on_all_channels(volatile adc_t *adc, uint32_t time)
{
    uint32_t all = 0;
    for (uint32_t channel = 0; channel < 10; ++channel)
        all |= time << 3 * channel;
    adc->SMPR1 = all & 0x00FFFFFF; // eight channels
    adc->SMPR2 = all;
}

void adc_reset_calibration(volatile adc_t *adc)
{
    adc->CR2 |= ADC_CR2_RSTCAL;
    while (adc->CR2 & ADC_CR2_RSTCAL) {
    }
}

void adc_calibrate(volatile adc_t *adc)
{
    adc->CR2 |= ADC_CR2_CAL;
    while (adc->CR2 & ADC_CR2_CAL) {
    }
}

void adc_set_regular_sequence(volatile adc_t *adc, uint32_t length, const uint8_t *channels)
{
    uint32_t words[3] = {0};
    for (uint32_t at = 0; at < length; ++at)
        words[at / 6] |= (uint32_t)channels[at] << 5 * (at % 6);
    adc->SQR3 = words[0];
    adc->SQR2 = words[1];
    adc->SQR1 = words[2] | (length - 1) << 20;
}

// The last of them stands in JSQ4, however many there are (RM0008, 11.12.12).
void adc_set_injected_sequence(volatile adc_t *adc, uint32_t length, const uint8_t *channels)
{
    uint32_t word = (length - 1) << 20;
    for (uint32_t at = 0; at < length; ++at)
        word |= (uint32_t)channels[at] << 5 * (4 - length + at);
    adc->JSQR = word;
}

void adc_start_conversion_direct(volatile adc_t *adc) { adc->CR2 |= ADC_CR2_ADON; }

void adc_start_conversion_injected(volatile adc_t *adc)
{
    adc->CR2 |= ADC_CR2_JSWSTART;
    while (adc->CR2 & ADC_CR2_JSWSTART) {
    }
}

bool adc_eoc(volatile adc_t *adc) { return adc->SR & ADC_SR_EOC; }

bool adc_eoc_injected(volatile adc_t *adc) { return adc->SR & ADC_SR_JEOC; }

uint32_t adc_read_regular(volatile adc_t *adc) { return adc->DR & 0xFFFF; }

uint32_t adc_read_injected(volatile adc_t *adc, uint32_t number) { return adc->JDR[number - 1]; }

void adc_enable_eoc_interrupt_injected(volatile adc_t *adc) { adc->CR1 |= ADC_CR1_JEOCIE; }
