// SPDX-License-Identifier: GPL-2.0-or-later
//
// A master that polls with a limit of time (RM0008, section 26). Interrupts are masked between ADDR and ACK or STOP, and between
// STOP and the last reads of DR.

#include "clock.h"
#include "hal_buses.h"

#define BUSY_TIMEOUT_MS 25u

typedef struct {
    uint32_t start, timeout_ms;
} limit_t;

static bool over(const limit_t *limit) { return hal_get_tick() - limit->start > limit->timeout_ms; }

hal_status_t hal_i2c_init(hal_i2c_t *i2c)
{
    volatile i2c_t *unit = i2c->instance;
    uint32_t pclk = clock_pclk1_hz(), mhz = pclk / 1000000;
    unit->CR1 &= ~I2C_CR1_PE;
    unit->CR1 |= I2C_CR1_SWRST;
    unit->CR1 &= ~I2C_CR1_SWRST;
    unit->CR2 = (unit->CR2 & ~0x3Fu) | mhz;
    unit->TRISE = i2c->hz <= 100000 ? mhz + 1 : mhz * 300 / 1000 + 1;
    unit->CCR = i2c->hz <= 100000 ? pclk / (2 * i2c->hz) : I2C_CCR_FAST | pclk / (3 * i2c->hz);
    unit->OAR1 = 1u << 14; // is to be kept at 1 (RM0008, 26.6.3)
    unit->OAR2 = 0;
    unit->CR1 |= I2C_CR1_PE;
    i2c->errors = 0;
    i2c->state = HAL_STATE_READY;
    return HAL_OK;
}

static hal_status_t wait_free(hal_i2c_t *i2c)
{
    limit_t limit = {hal_get_tick(), BUSY_TIMEOUT_MS};
    while (i2c->instance->SR2 & I2C_SR2_BUSY)
        if (over(&limit))
            return HAL_BUSY;
    return HAL_OK;
}

static hal_status_t wait_flag(hal_i2c_t *i2c, uint32_t flag, const limit_t *limit)
{
    while (!(i2c->instance->SR1 & flag)) {
        if (i2c->instance->SR1 & I2C_SR1_AF) {
            i2c->instance->CR1 |= I2C_CR1_STOP;
            i2c->instance->SR1 = ~I2C_SR1_AF;
            i2c->errors |= I2C_SR1_AF;
            return HAL_ERROR;
        }
        if (over(limit))
            return HAL_TIMEOUT;
    }
    return HAL_OK;
}

static void clear_addr(hal_i2c_t *i2c)
{
    (void)i2c->instance->SR1;
    (void)i2c->instance->SR2;
}

static hal_status_t begin(hal_i2c_t *i2c, uint8_t address, const limit_t *limit)
{
    i2c->instance->CR1 |= I2C_CR1_START;
    if (wait_flag(i2c, I2C_SR1_SB, limit) != HAL_OK)
        return HAL_TIMEOUT;
    i2c->instance->DR = address;
    return wait_flag(i2c, I2C_SR1_ADDR, limit);
}

static hal_status_t begin_at(hal_i2c_t *i2c, uint8_t address, uint8_t place, const limit_t *limit)
{
    hal_status_t status = begin(i2c, address, limit);
    if (status != HAL_OK)
        return status;
    clear_addr(i2c);
    status = wait_flag(i2c, I2C_SR1_TXE, limit);
    if (status == HAL_OK)
        i2c->instance->DR = place;
    return status;
}

hal_status_t hal_i2c_is_device_ready(hal_i2c_t *i2c, uint8_t address, uint32_t trials, uint32_t timeout_ms)
{
    if (wait_free(i2c) != HAL_OK)
        return HAL_BUSY;
    i2c->instance->CR1 &= ~I2C_CR1_POS;
    for (uint32_t trial = 0; trial < trials; ++trial) {
        limit_t limit = {hal_get_tick(), timeout_ms};
        bool good = begin(i2c, address, &limit) == HAL_OK;
        if (good) {
            i2c->instance->CR1 |= I2C_CR1_STOP;
            clear_addr(i2c);
        }
        if (wait_free(i2c) != HAL_OK)
            return HAL_ERROR;
        if (good)
            return HAL_OK;
    }
    return HAL_ERROR;
}

static hal_status_t send_all(hal_i2c_t *i2c, const uint8_t *data, size_t size, const limit_t *limit)
{
    while (size) {
        hal_status_t status = wait_flag(i2c, I2C_SR1_TXE, limit);
        if (status != HAL_OK)
            return status;
        i2c->instance->DR = *data++;
        --size;
        if (size && i2c->instance->SR1 & I2C_SR1_BTF) {
            i2c->instance->DR = *data++;
            --size;
        }
    }
    return wait_flag(i2c, I2C_SR1_BTF, limit);
}

hal_status_t hal_i2c_mem_write(hal_i2c_t *i2c, uint8_t address, uint8_t place, const uint8_t *data, size_t size,
                               uint32_t timeout_ms)
{
    limit_t limit = {hal_get_tick(), timeout_ms};
    if (i2c->state != HAL_STATE_READY || wait_free(i2c) != HAL_OK)
        return HAL_BUSY;
    i2c->state = HAL_STATE_BUSY;
    i2c->instance->CR1 &= ~I2C_CR1_POS;
    hal_status_t status = begin_at(i2c, address, place, &limit);
    if (status == HAL_OK)
        status = send_all(i2c, data, size, &limit);
    if (status == HAL_OK)
        i2c->instance->CR1 |= I2C_CR1_STOP;
    i2c->state = HAL_STATE_READY;
    return status;
}

static void answer_address(hal_i2c_t *i2c, size_t size)
{
    if (size == 1)
        i2c->instance->CR1 &= ~I2C_CR1_ACK;
    if (size == 2)
        i2c->instance->CR1 |= I2C_CR1_POS;
    irq_disable();
    clear_addr(i2c);
    if (size == 1)
        i2c->instance->CR1 |= I2C_CR1_STOP;
    if (size == 2)
        i2c->instance->CR1 &= ~I2C_CR1_ACK;
    irq_enable();
}

static hal_status_t receive_all(hal_i2c_t *i2c, uint8_t *data, size_t size, const limit_t *limit)
{
    volatile i2c_t *unit = i2c->instance;
    hal_status_t status = HAL_OK;
    while (size && status == HAL_OK) {
        status = wait_flag(i2c, size == 2 || size == 3 ? I2C_SR1_BTF : I2C_SR1_RXNE, limit);
        if (status != HAL_OK)
            return status;
        if (size == 3) {
            unit->CR1 &= ~I2C_CR1_ACK;
        } else if (size == 2) {
            irq_disable();
            unit->CR1 |= I2C_CR1_STOP;
            *data++ = (uint8_t)unit->DR;
            irq_enable();
            --size;
        }
        *data++ = (uint8_t)unit->DR;
        --size;
    }
    return status;
}

hal_status_t hal_i2c_mem_read(hal_i2c_t *i2c, uint8_t address, uint8_t place, uint8_t *data, size_t size, uint32_t timeout_ms)
{
    limit_t limit = {hal_get_tick(), timeout_ms};
    if (i2c->state != HAL_STATE_READY || wait_free(i2c) != HAL_OK)
        return HAL_BUSY;
    i2c->state = HAL_STATE_BUSY;
    i2c->instance->CR1 &= ~I2C_CR1_POS;
    i2c->instance->CR1 |= I2C_CR1_ACK;
    hal_status_t status = begin_at(i2c, address, place, &limit);
    if (status == HAL_OK)
        status = wait_flag(i2c, I2C_SR1_TXE, &limit);
    if (status == HAL_OK)
        status = begin(i2c, address | 1, &limit);
    if (status == HAL_OK) {
        answer_address(i2c, size);
        status = receive_all(i2c, data, size, &limit);
    }
    i2c->state = HAL_STATE_READY;
    return status;
}
