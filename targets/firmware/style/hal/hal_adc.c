// SPDX-License-Identifier: GPL-2.0-or-later
//
// What was written is read back and compared; a start writes SWSTART and EXTTRIG at once (RM0008, section 11.12.3).

#include "cycles.h"
#include "hal_buses.h"

#define READY_TIMEOUT_MS 2u
#define CALIBRATION_TIMEOUT_MS 10u

__attribute__((weak)) void hal_adc_complete_callback(hal_adc_t *adc) { (void)adc; }

static hal_status_t wait_control(hal_adc_t *adc, uint32_t bit, bool set, uint32_t timeout_ms)
{
    uint32_t start = hal_get_tick();
    while (!(adc->instance->CR2 & bit) == set)
        if (hal_get_tick() - start > timeout_ms)
            return HAL_TIMEOUT;
    return HAL_OK;
}

static hal_status_t enable(hal_adc_t *adc)
{
    if (adc->instance->CR2 & ADC_CR2_ADON)
        return HAL_OK;
    adc->instance->CR2 |= ADC_CR2_ADON;
    wait_cycles(72);
    return wait_control(adc, ADC_CR2_ADON, true, READY_TIMEOUT_MS);
}

static hal_status_t disable(hal_adc_t *adc)
{
    if (!(adc->instance->CR2 & ADC_CR2_ADON))
        return HAL_OK;
    adc->instance->CR2 &= ~ADC_CR2_ADON;
    return wait_control(adc, ADC_CR2_ADON, false, READY_TIMEOUT_MS);
}

hal_status_t hal_adc_init(hal_adc_t *adc)
{
    if (disable(adc) != HAL_OK)
        return HAL_ERROR;
    uint32_t control = ADC_BY_SOFTWARE << ADC_CR2_EXTSEL_SHIFT, scan = adc->scan ? ADC_CR1_SCAN : 0;
    volatile adc_t *unit = adc->instance;
    unit->CR1 = (unit->CR1 & ~(ADC_CR1_SCAN | ADC_CR1_DISCEN | 7u << ADC_CR1_DISCNUM_SHIFT)) | scan;
    unit->CR2 = (unit->CR2 & ~(ADC_CR2_ALIGN | 7u << ADC_CR2_EXTSEL_SHIFT | ADC_CR2_EXTTRIG | ADC_CR2_CONT)) | control;
    unit->SQR1 = (unit->SQR1 & ~(0xFu << 20)) | (adc->conversions - 1) << 20;
    uint32_t others = ADC_CR2_ADON | ADC_CR2_DMA | ADC_CR2_SWSTART | ADC_CR2_JSWSTART | ADC_CR2_JEXTTRIG |
                      7u << ADC_CR2_JEXTSEL_SHIFT | ADC_CR2_TSVREFE;
    if ((unit->CR2 & ~others) != control)
        return HAL_ERROR;
    adc->state = HAL_STATE_READY;
    return HAL_OK;
}

hal_status_t hal_adc_config_channel(hal_adc_t *adc, uint32_t channel, uint32_t rank, uint32_t sampling)
{
    volatile adc_t *unit = adc->instance;
    uint32_t shift = 5 * (rank - 1);
    unit->SQR3 = (unit->SQR3 & ~(0x1Fu << shift)) | channel << shift;
    volatile uint32_t *times = channel < 10 ? &unit->SMPR2 : &unit->SMPR1;
    *times = (*times & ~(7u << 3 * (channel % 10))) | sampling << 3 * (channel % 10);
    if (channel >= ADC_SENSOR && !(unit->CR2 & ADC_CR2_TSVREFE)) {
        unit->CR2 |= ADC_CR2_TSVREFE;
        wait_cycles(72 * 10); // the sensor takes up to 10 us to start
    }
    return HAL_OK;
}

hal_status_t hal_adc_calibration_start(hal_adc_t *adc)
{
    if (disable(adc) != HAL_OK)
        return HAL_ERROR;
    wait_cycles(72);
    if (enable(adc) != HAL_OK)
        return HAL_ERROR;
    adc->instance->CR2 |= ADC_CR2_RSTCAL;
    if (wait_control(adc, ADC_CR2_RSTCAL, false, CALIBRATION_TIMEOUT_MS) != HAL_OK)
        return HAL_ERROR;
    adc->instance->CR2 |= ADC_CR2_CAL;
    return wait_control(adc, ADC_CR2_CAL, false, CALIBRATION_TIMEOUT_MS);
}

static hal_status_t start(hal_adc_t *adc, uint32_t more)
{
    if (adc->state != HAL_STATE_READY)
        return HAL_BUSY;
    if (enable(adc) != HAL_OK)
        return HAL_ERROR;
    adc->state = HAL_STATE_BUSY;
    adc->instance->SR = ~ADC_SR_EOC;
    adc->instance->CR2 |= more;
    adc->instance->CR2 |= ADC_CR2_SWSTART | ADC_CR2_EXTTRIG;
    return HAL_OK;
}

hal_status_t hal_adc_start(hal_adc_t *adc) { return start(adc, 0); }

hal_status_t hal_adc_poll_for_conversion(hal_adc_t *adc, uint32_t timeout_ms)
{
    uint32_t begin = hal_get_tick();
    while (!(adc->instance->SR & ADC_SR_EOC))
        if (hal_get_tick() - begin > timeout_ms)
            return HAL_TIMEOUT;
    adc->instance->SR = ~(ADC_SR_STRT | ADC_SR_EOC);
    adc->state = HAL_STATE_READY;
    return HAL_OK;
}

uint32_t hal_adc_get_value(hal_adc_t *adc) { return adc->instance->DR; }

hal_status_t hal_adc_stop(hal_adc_t *adc)
{
    adc->state = HAL_STATE_READY;
    return disable(adc);
}

static void dma_complete(hal_dma_t *dma)
{
    hal_adc_t *adc = dma->parent;
    adc->state = HAL_STATE_READY;
    hal_adc_complete_callback(adc);
}

hal_status_t hal_adc_start_dma(hal_adc_t *adc, uint16_t *data, uint32_t count)
{
    adc->dma->complete = dma_complete;
    adc->dma->parent = adc;
    hal_dma_start_it(adc->dma, &adc->instance->DR, data, count);
    return start(adc, ADC_CR2_DMA);
}

hal_status_t hal_adc_stop_dma(hal_adc_t *adc)
{
    hal_status_t status = hal_adc_stop(adc);
    adc->instance->CR2 &= ~ADC_CR2_DMA;
    DMA1_CHANNEL(adc->dma->channel)->CCR &= ~DMA_CCR_EN;
    return status;
}
