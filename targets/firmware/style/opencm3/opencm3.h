// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of libopencm3: a function for each field of a register, each of which reads, changes and writes that register;
// drivers that poll without a limit; interrupts named *_isr. Only what this image calls.

#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "chip/adc.h"
#include "chip/i2c.h"
#include "chip/rtc.h"
#include "chip/spi.h"
#include "chip/stm32f103.h"

// --- vectors

void sys_tick_handler(void);
void rtc_isr(void);
void adc1_2_isr(void);

// --- clocks: the register's offset and the bit in one number

#define RCC_GATE(offset, bit) ((offset) << 5 | (bit))

enum rcc_gate {
    RCC_GATE_GPIOA = RCC_GATE(0x18, 2),
    RCC_GATE_GPIOB = RCC_GATE(0x18, 3),
    RCC_GATE_GPIOC = RCC_GATE(0x18, 4),
    RCC_GATE_ADC1 = RCC_GATE(0x18, 9),
    RCC_GATE_SPI1 = RCC_GATE(0x18, 12),
    RCC_GATE_USART1 = RCC_GATE(0x18, 14),
    RCC_GATE_I2C1 = RCC_GATE(0x1C, 21),
    RCC_GATE_BKP = RCC_GATE(0x1C, 27),
    RCC_GATE_PWR = RCC_GATE(0x1C, 28),
};

extern uint32_t rcc_ahb_frequency, rcc_apb1_frequency, rcc_apb2_frequency;

void rcc_clock_setup_in_hse_8mhz_out_72mhz(void);
void rcc_periph_clock_enable(enum rcc_gate gate);
void rcc_periph_reset_pulse(enum rcc_gate gate);

// --- pins: MODE and CNF, apart

#define GPIO_MODE_INPUT 0u
#define GPIO_MODE_OUTPUT_2_MHZ 2u
#define GPIO_MODE_OUTPUT_50_MHZ 3u
#define GPIO_CNF_INPUT_ANALOG 0u
#define GPIO_CNF_INPUT_PULL_UPDOWN 2u
#define GPIO_CNF_OUTPUT_PUSHPULL 0u
#define GPIO_CNF_OUTPUT_ALTFN_PUSHPULL 2u
#define GPIO_CNF_OUTPUT_ALTFN_OPENDRAIN 3u

void gpio_set_mode(volatile gpio_t *port, uint32_t mode, uint32_t cnf, uint32_t pins);
void gpio_set(volatile gpio_t *port, uint32_t pins);
void gpio_clear(volatile gpio_t *port, uint32_t pins);

// --- core

void nvic_enable_irq(enum irq irq);
void systick_set_clocksource(uint32_t source);
void systick_set_reload(uint32_t value);
void systick_interrupt_enable(void);
void systick_counter_enable(void);

// --- serial line

void usart_set_baudrate(volatile usart_t *usart, uint32_t baud);
void usart_set_databits(volatile usart_t *usart, uint32_t bits);
void usart_set_stopbits(volatile usart_t *usart, uint32_t stopbits);
void usart_set_mode(volatile usart_t *usart, uint32_t mode);
void usart_set_parity(volatile usart_t *usart, uint32_t parity);
void usart_set_flow_control(volatile usart_t *usart, uint32_t flow_control);
void usart_enable(volatile usart_t *usart);
void usart_send_blocking(volatile usart_t *usart, uint16_t data);

// --- converter

#define ADC_SMPR_239DOT5CYC 7u

void adc_power_off(volatile adc_t *adc);
void adc_power_on(volatile adc_t *adc);
void adc_enable_scan_mode(volatile adc_t *adc);
void adc_disable_scan_mode(volatile adc_t *adc);
void adc_set_single_conversion_mode(volatile adc_t *adc);
void adc_disable_external_trigger_regular(volatile adc_t *adc);
void adc_enable_external_trigger_injected(volatile adc_t *adc, uint32_t source);
void adc_set_right_aligned(volatile adc_t *adc);
void adc_enable_temperature_sensor(volatile adc_t *adc);
void adc_set_sample_time_on_all_channels(volatile adc_t *adc, uint32_t time);
void adc_reset_calibration(volatile adc_t *adc);
void adc_calibrate(volatile adc_t *adc);
void adc_set_regular_sequence(volatile adc_t *adc, uint32_t length, const uint8_t *channels);
void adc_set_injected_sequence(volatile adc_t *adc, uint32_t length, const uint8_t *channels);
void adc_start_conversion_direct(volatile adc_t *adc);
void adc_start_conversion_injected(volatile adc_t *adc);
bool adc_eoc(volatile adc_t *adc);
bool adc_eoc_injected(volatile adc_t *adc);
uint32_t adc_read_regular(volatile adc_t *adc);
uint32_t adc_read_injected(volatile adc_t *adc, uint32_t number);
void adc_enable_eoc_interrupt_injected(volatile adc_t *adc);

// --- I2C

enum i2c_direction { I2C_WRITE, I2C_READ };

void i2c_peripheral_enable(volatile i2c_t *i2c);
void i2c_peripheral_disable(volatile i2c_t *i2c);
void i2c_set_clock_frequency(volatile i2c_t *i2c, uint32_t mhz);
void i2c_set_fast_mode(volatile i2c_t *i2c);
void i2c_set_ccr(volatile i2c_t *i2c, uint32_t value);
void i2c_set_trise(volatile i2c_t *i2c, uint32_t value);
void i2c_set_own_7bit_slave_address(volatile i2c_t *i2c, uint8_t address);
void i2c_send_start(volatile i2c_t *i2c);
void i2c_send_stop(volatile i2c_t *i2c);
void i2c_enable_ack(volatile i2c_t *i2c);
void i2c_disable_ack(volatile i2c_t *i2c);
void i2c_send_7bit_address(volatile i2c_t *i2c, uint8_t address, enum i2c_direction direction);
void i2c_send_data(volatile i2c_t *i2c, uint8_t data);
uint8_t i2c_get_data(volatile i2c_t *i2c);
void i2c_transfer7(volatile i2c_t *i2c, uint8_t address, const uint8_t *out, uint32_t out_count, uint8_t *in, uint32_t in_count);

// --- SPI

#define SPI_BAUDRATE_FPCLK_DIV_8 2u
#define SPI_CLOCK_IDLE_LOW 0u
#define SPI_CLOCK_FIRST_TRANSITION 0u
#define SPI_DFF_8BIT 0u
#define SPI_MSBFIRST 0u

void spi_init_master(volatile spi_t *spi, uint32_t baud, uint32_t polarity, uint32_t phase, uint32_t dff, uint32_t order);
void spi_enable_software_slave_management(volatile spi_t *spi);
void spi_set_nss_high(volatile spi_t *spi);
void spi_enable(volatile spi_t *spi);
void spi_send(volatile spi_t *spi, uint16_t data);
uint16_t spi_read(volatile spi_t *spi);
uint16_t spi_xfer(volatile spi_t *spi, uint16_t data);
uint16_t spi_clean_disable(volatile spi_t *spi);

// --- real-time clock

void rtc_auto_awake_lsi(uint32_t prescaler);
void rtc_set_counter_val(uint32_t value);
void rtc_set_alarm_time(uint32_t value);
uint32_t rtc_get_counter_val(void);
void rtc_interrupt_enable(uint32_t flag);
bool rtc_check_flag(uint32_t flag);
void rtc_clear_flag(uint32_t flag);
