// SPDX-License-Identifier: GPL-2.0-or-later
//
// A master that polls (RM0008, section 26). After a START, SB is looked for in SR1, then MSL and BUSY in SR2; each byte that
// is sent waits for BTF, each that comes for RXNE. ACK is taken back before the last byte is waited for, and STOP follows
// it. An address to which nobody answers is waited for without end.

#include "opencm3.h"

void i2c_peripheral_enable(volatile i2c_t *i2c) { i2c->CR1 |= I2C_CR1_PE; }

void i2c_peripheral_disable(volatile i2c_t *i2c) { i2c->CR1 &= ~I2C_CR1_PE; }

void i2c_set_clock_frequency(volatile i2c_t *i2c, uint32_t mhz) { i2c->CR2 = (i2c->CR2 & ~0x3Fu) | mhz; }

void i2c_set_fast_mode(volatile i2c_t *i2c) { i2c->CCR |= I2C_CCR_FAST; }

void i2c_set_ccr(volatile i2c_t *i2c, uint32_t value) { i2c->CCR = (i2c->CCR & ~0xFFFu) | (value & 0xFFF); }

void i2c_set_trise(volatile i2c_t *i2c, uint32_t value) { i2c->TRISE = value; }

void i2c_set_own_7bit_slave_address(volatile i2c_t *i2c, uint8_t address)
{
    i2c->OAR1 = (uint32_t)address << 1 | 1u << 14; // bit 14 is to be kept at 1 (RM0008, 26.6.3)
}

void i2c_send_start(volatile i2c_t *i2c) { i2c->CR1 |= I2C_CR1_START; }

void i2c_send_stop(volatile i2c_t *i2c) { i2c->CR1 |= I2C_CR1_STOP; }

void i2c_enable_ack(volatile i2c_t *i2c) { i2c->CR1 |= I2C_CR1_ACK; }

void i2c_disable_ack(volatile i2c_t *i2c) { i2c->CR1 &= ~I2C_CR1_ACK; }

void i2c_send_7bit_address(volatile i2c_t *i2c, uint8_t address, enum i2c_direction direction)
{
    i2c->DR = (uint8_t)(address << 1 | direction);
}

void i2c_send_data(volatile i2c_t *i2c, uint8_t data) { i2c->DR = data; }

uint8_t i2c_get_data(volatile i2c_t *i2c) { return i2c->DR & 0xFF; }

static void begin(volatile i2c_t *i2c, uint8_t address, enum i2c_direction direction)
{
    while (!((i2c->SR1 & I2C_SR1_SB) && (i2c->SR2 & I2C_SR2_MSL) && (i2c->SR2 & I2C_SR2_BUSY))) {
    }
    i2c_send_7bit_address(i2c, address, direction);
    while (!(i2c->SR1 & I2C_SR1_ADDR)) {
    }
    (void)i2c->SR2;
}

static void send(volatile i2c_t *i2c, uint8_t address, const uint8_t *data, uint32_t count)
{
    while (i2c->SR2 & I2C_SR2_BUSY) {
    }
    i2c_send_start(i2c);
    begin(i2c, address, I2C_WRITE);
    for (; count; --count) {
        i2c_send_data(i2c, *data++);
        while (!(i2c->SR1 & I2C_SR1_BTF)) {
        }
    }
}

static void receive(volatile i2c_t *i2c, uint8_t address, uint8_t *data, uint32_t count)
{
    i2c_send_start(i2c);
    i2c_enable_ack(i2c);
    begin(i2c, address, I2C_READ);
    for (; count; --count) {
        if (count == 1)
            i2c_disable_ack(i2c);
        while (!(i2c->SR1 & I2C_SR1_RXNE)) {
        }
        *data++ = i2c_get_data(i2c);
    }
    i2c_send_stop(i2c);
}

void i2c_transfer7(volatile i2c_t *i2c, uint8_t address, const uint8_t *out, uint32_t out_count, uint8_t *in, uint32_t in_count)
{
    if (out_count)
        send(i2c, address, out, out_count);
    if (in_count)
        receive(i2c, address, in, in_count);
    else
        i2c_send_stop(i2c);
}
