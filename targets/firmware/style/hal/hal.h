// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: a hardware abstraction layer. A handle for each peripheral with its settings and its state, a status
// from each call, time-outs on a tick of 1 ms, and weak callbacks that the application replaces. Written for this firmware.

#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "chip/stm32f103.h"

typedef enum { HAL_OK, HAL_ERROR, HAL_BUSY, HAL_TIMEOUT } hal_status_t;
typedef enum { HAL_STATE_RESET, HAL_STATE_READY, HAL_STATE_BUSY } hal_state_t;

#define HAL_FOREVER 0xFFFFFFFFu

// --- Tick (hal_tick.c)

hal_status_t hal_init(void);
hal_status_t hal_init_tick(void); // again after a change of HCLK
uint32_t hal_get_tick(void);
void hal_inc_tick(void); // weak
void hal_delay(uint32_t ms);

// --- Clock (hal_rcc.c)

typedef struct {
    bool hse_on;
    uint32_t pll_factor;       // 2 to 16, of HSE; 0 for no PLL
    uint32_t apb1_divider;     // as PPRE1
    uint32_t flash_wait_states; // 0 to 2
} hal_clock_config_t;

hal_status_t hal_clock_config(const hal_clock_config_t *config);

// --- Pins (hal_gpio.c)

void hal_gpio_init(volatile gpio_t *port, uint16_t pins, uint32_t mode, bool pull_up);
void hal_gpio_write(volatile gpio_t *port, uint16_t pins, bool level);
void hal_gpio_toggle(volatile gpio_t *port, uint16_t pins);

// --- Serial port (hal_uart.c)

typedef struct {
    volatile usart_t *instance;
    uint32_t baud;
    volatile hal_state_t tx_state, rx_state;
    const uint8_t *tx_data;
    volatile size_t tx_left;
    uint8_t *rx_data;
    volatile size_t rx_left;
    volatile uint32_t errors; // bits of USART_SR
} hal_uart_t;

hal_status_t hal_uart_init(hal_uart_t *uart);
hal_status_t hal_uart_transmit(hal_uart_t *uart, const uint8_t *data, size_t size, uint32_t timeout_ms);
hal_status_t hal_uart_receive(hal_uart_t *uart, uint8_t *data, size_t size, uint32_t timeout_ms);
hal_status_t hal_uart_transmit_it(hal_uart_t *uart, const uint8_t *data, size_t size);
hal_status_t hal_uart_receive_it(hal_uart_t *uart, uint8_t *data, size_t size);
void hal_uart_irq_handler(hal_uart_t *uart);
void hal_uart_msp_init(hal_uart_t *uart);         // weak: clocks, pins, interrupt
void hal_uart_tx_complete_callback(hal_uart_t *uart); // weak
void hal_uart_rx_complete_callback(hal_uart_t *uart); // weak

// --- Timer (hal_tim.c)

typedef struct {
    volatile tim_t *instance;
    uint32_t prescaler, period; // as written to PSC and ARR
    hal_state_t state;
} hal_tim_t;

hal_status_t hal_tim_base_init(hal_tim_t *tim);
hal_status_t hal_tim_base_start_it(hal_tim_t *tim);
hal_status_t hal_tim_pwm_start(hal_tim_t *tim, unsigned channel, uint32_t pulse);
void hal_tim_irq_handler(hal_tim_t *tim);
void hal_tim_msp_init(hal_tim_t *tim);               // weak
void hal_tim_period_elapsed_callback(hal_tim_t *tim); // weak
