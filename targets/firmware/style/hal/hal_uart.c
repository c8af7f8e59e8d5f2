// SPDX-License-Identifier: GPL-2.0-or-later

#include "clock.h"
#include "hal.h"

#define LINE_ERRORS (USART_SR_ORE | USART_SR_NE | USART_SR_FE | USART_SR_PE)

__attribute__((weak)) void hal_uart_msp_init(hal_uart_t *uart) { (void)uart; }
__attribute__((weak)) void hal_uart_tx_complete_callback(hal_uart_t *uart) { (void)uart; }
__attribute__((weak)) void hal_uart_rx_complete_callback(hal_uart_t *uart) { (void)uart; }

hal_status_t hal_uart_init(hal_uart_t *uart)
{
    if (!uart || !uart->instance || !uart->baud)
        return HAL_ERROR;
    if (uart->tx_state == HAL_STATE_RESET)
        hal_uart_msp_init(uart);
    volatile usart_t *usart = uart->instance;
    usart->CR1 &= ~USART_CR1_UE;
    usart->CR2 = 0;
    usart->CR3 = 0;
    uint32_t pclk = usart == USART1 ? clock_pclk2_hz() : clock_pclk1_hz();
    usart->BRR = (pclk + uart->baud / 2) / uart->baud;
    usart->CR1 = USART_CR1_TE | USART_CR1_RE;
    usart->CR1 |= USART_CR1_UE;
    uart->errors = 0;
    uart->tx_state = uart->rx_state = HAL_STATE_READY;
    return HAL_OK;
}

static hal_status_t wait_flag(hal_uart_t *uart, uint32_t flag, uint32_t start, uint32_t timeout_ms)
{
    while (!(uart->instance->SR & flag))
        if (timeout_ms != HAL_FOREVER && hal_get_tick() - start >= timeout_ms)
            return HAL_TIMEOUT;
    return HAL_OK;
}

hal_status_t hal_uart_transmit(hal_uart_t *uart, const uint8_t *data, size_t size, uint32_t timeout_ms)
{
    if (uart->tx_state != HAL_STATE_READY)
        return HAL_BUSY;
    if (!data || !size)
        return HAL_ERROR;
    uart->tx_state = HAL_STATE_BUSY;
    uint32_t start = hal_get_tick();
    hal_status_t status = HAL_OK;
    while (size-- && status == HAL_OK) {
        status = wait_flag(uart, USART_SR_TXE, start, timeout_ms);
        if (status == HAL_OK)
            uart->instance->DR = *data++;
    }
    if (status == HAL_OK)
        status = wait_flag(uart, USART_SR_TC, start, timeout_ms);
    uart->tx_state = HAL_STATE_READY;
    return status;
}

hal_status_t hal_uart_receive(hal_uart_t *uart, uint8_t *data, size_t size, uint32_t timeout_ms)
{
    if (uart->rx_state != HAL_STATE_READY)
        return HAL_BUSY;
    if (!data || !size)
        return HAL_ERROR;
    uart->rx_state = HAL_STATE_BUSY;
    uint32_t start = hal_get_tick();
    hal_status_t status = HAL_OK;
    while (size-- && status == HAL_OK) {
        status = wait_flag(uart, USART_SR_RXNE, start, timeout_ms);
        if (status == HAL_OK)
            *data++ = (uint8_t)uart->instance->DR;
    }
    uart->rx_state = HAL_STATE_READY;
    return status;
}

hal_status_t hal_uart_transmit_it(hal_uart_t *uart, const uint8_t *data, size_t size)
{
    if (uart->tx_state != HAL_STATE_READY)
        return HAL_BUSY;
    uart->tx_data = data;
    uart->tx_left = size;
    uart->tx_state = HAL_STATE_BUSY;
    uart->instance->CR1 |= USART_CR1_TXEIE;
    return HAL_OK;
}

hal_status_t hal_uart_receive_it(hal_uart_t *uart, uint8_t *data, size_t size)
{
    if (uart->rx_state != HAL_STATE_READY)
        return HAL_BUSY;
    uart->rx_data = data;
    uart->rx_left = size;
    uart->rx_state = HAL_STATE_BUSY;
    uart->instance->CR3 |= USART_CR3_EIE;
    uart->instance->CR1 |= USART_CR1_PEIE | USART_CR1_RXNEIE;
    return HAL_OK;
}

static void receive_one(hal_uart_t *uart)
{
    *uart->rx_data++ = (uint8_t)uart->instance->DR;
    if (--uart->rx_left)
        return;
    uart->instance->CR1 &= ~(USART_CR1_RXNEIE | USART_CR1_PEIE);
    uart->instance->CR3 &= ~USART_CR3_EIE;
    uart->rx_state = HAL_STATE_READY;
    hal_uart_rx_complete_callback(uart);
}

// After the last byte is handed over, what is waited for is TC, the end of its frame.
static void transmit_one(hal_uart_t *uart)
{
    uart->instance->DR = *uart->tx_data++;
    if (--uart->tx_left)
        return;
    uart->instance->CR1 &= ~USART_CR1_TXEIE;
    uart->instance->CR1 |= USART_CR1_TCIE;
}

void hal_uart_irq_handler(hal_uart_t *uart)
{
    uint32_t sr = uart->instance->SR;
    uint32_t cr1 = uart->instance->CR1;
    if (sr & LINE_ERRORS) {
        uart->errors |= sr & LINE_ERRORS;
        if (!(sr & USART_SR_RXNE))
            (void)uart->instance->DR; // the read of SR above and this one clear the flags
    }
    if (sr & USART_SR_RXNE && cr1 & USART_CR1_RXNEIE) {
        receive_one(uart);
        return;
    }
    if (sr & USART_SR_TXE && cr1 & USART_CR1_TXEIE) {
        transmit_one(uart);
        return;
    }
    if (sr & USART_SR_TC && cr1 & USART_CR1_TCIE) {
        uart->instance->CR1 &= ~USART_CR1_TCIE;
        uart->tx_state = HAL_STATE_READY;
        hal_uart_tx_complete_callback(uart);
    }
}
