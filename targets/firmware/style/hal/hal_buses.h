// SPDX-License-Identifier: GPL-2.0-or-later
//
// Of the same layer: converter, I2C, SPI and real-time clock.

#pragma once

#include "chip/adc.h"
#include "chip/i2c.h"
#include "chip/rtc.h"
#include "chip/spi.h"
#include "hal.h"

// --- DMA (hal_dma.c)

typedef struct hal_dma {
    unsigned channel;
    uint32_t settings; // as CCR, without EN and interrupts
    void (*complete)(struct hal_dma *dma);
    void *parent;
} hal_dma_t;

void hal_dma_start_it(hal_dma_t *dma, volatile uint32_t *peripheral, volatile void *memory, uint32_t count);
void hal_dma_irq_handler(hal_dma_t *dma);

// --- Converter (hal_adc.c)

typedef struct {
    volatile adc_t *instance;
    bool scan;
    uint32_t conversions; // of the regular group
    hal_dma_t *dma;
    hal_state_t state;
} hal_adc_t;

hal_status_t hal_adc_init(hal_adc_t *adc);
hal_status_t hal_adc_config_channel(hal_adc_t *adc, uint32_t channel, uint32_t rank, uint32_t sampling); // rank 1 to 6
hal_status_t hal_adc_calibration_start(hal_adc_t *adc);
hal_status_t hal_adc_start(hal_adc_t *adc);
hal_status_t hal_adc_poll_for_conversion(hal_adc_t *adc, uint32_t timeout_ms);
uint32_t hal_adc_get_value(hal_adc_t *adc);
hal_status_t hal_adc_stop(hal_adc_t *adc);
hal_status_t hal_adc_start_dma(hal_adc_t *adc, uint16_t *data, uint32_t count);
hal_status_t hal_adc_stop_dma(hal_adc_t *adc);
void hal_adc_complete_callback(hal_adc_t *adc); // weak

// --- I2C (hal_i2c.c); addresses as they lie on the bus, with a bit for the direction

typedef struct {
    volatile i2c_t *instance;
    uint32_t hz;
    hal_state_t state;
    uint32_t errors; // bits of I2C_SR1
} hal_i2c_t;

hal_status_t hal_i2c_init(hal_i2c_t *i2c);
hal_status_t hal_i2c_is_device_ready(hal_i2c_t *i2c, uint8_t address, uint32_t trials, uint32_t timeout_ms);
hal_status_t hal_i2c_mem_write(hal_i2c_t *i2c, uint8_t address, uint8_t place, const uint8_t *data, size_t size,
                               uint32_t timeout_ms);
hal_status_t hal_i2c_mem_read(hal_i2c_t *i2c, uint8_t address, uint8_t place, uint8_t *data, size_t size, uint32_t timeout_ms);

// --- SPI (hal_spi.c)

typedef struct {
    volatile spi_t *instance;
    uint32_t divider; // as BR
    hal_dma_t *rx_dma, *tx_dma;
    volatile hal_state_t state;
} hal_spi_t;

hal_status_t hal_spi_init(hal_spi_t *spi);
hal_status_t hal_spi_transmit(hal_spi_t *spi, const uint8_t *data, size_t size, uint32_t timeout_ms);
hal_status_t hal_spi_transmit_receive(hal_spi_t *spi, const uint8_t *out, uint8_t *in, size_t size, uint32_t timeout_ms);
hal_status_t hal_spi_receive(hal_spi_t *spi, uint8_t *data, size_t size, uint32_t timeout_ms);
hal_status_t hal_spi_transmit_receive_dma(hal_spi_t *spi, const uint8_t *out, uint8_t *in, size_t size);

// --- Real-time clock (hal_rtc.c)

typedef struct {
    uint8_t hours, minutes, seconds;
} hal_time_t;

hal_status_t hal_rtc_init(uint32_t prescaler);
hal_status_t hal_rtc_set_time(hal_time_t time);
hal_time_t hal_rtc_get_time(void);
hal_status_t hal_rtc_set_alarm_it(hal_time_t time);
void hal_rtc_alarm_irq_handler(void);
void hal_rtc_alarm_callback(void); // weak
