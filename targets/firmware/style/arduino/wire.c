// SPDX-License-Identifier: GPL-2.0-or-later
//
// Wire on I2C1 (PB6, PB7), by interrupts. The handler reads SR1 and SR2 first of all, so that ADDR is cleared before it decides
// anything; the caller waits for its end, at most TIMEOUT_MS. A message without STOP is one with a repeated START after it.

#include "arduino.h"
#include "chip/i2c.h"
#include "chip/stm32f103.h"
#include "handlers.h"

#define TIMEOUT_MS 10u
#define PCLK1_HZ 36000000u
#define EVENTS (I2C_CR2_ITEVTEN | I2C_CR2_ITERREN)

static uint8_t out[WIRE_BUFFER], in[WIRE_BUFFER], target;
static uint32_t out_count, in_count, in_place;
static bool too_long;

static struct {
    uint8_t *data;
    uint32_t count, place;
    bool reading, stop;
    volatile bool over;
    volatile enum wire_status status;
} job;

static void finish(enum wire_status status)
{
    I2C1->CR2 &= ~(EVENTS | I2C_CR2_ITBUFEN);
    job.status = status;
    job.over = true;
}

static void last_was_sent(void)
{
    if (job.stop)
        I2C1->CR1 |= I2C_CR1_STOP;
    finish(WIRE_SUCCESS);
}

static void address_was_sent(void)
{
    if (job.reading && job.count == 1)
        I2C1->CR1 = (I2C1->CR1 & ~I2C_CR1_ACK) | I2C_CR1_STOP;
    else if (!job.reading && !job.count)
        last_was_sent();
    else if (!job.reading)
        I2C1->DR = job.data[job.place++];
}

static void send_next(void)
{
    if (job.place < job.count)
        I2C1->DR = job.data[job.place++];
    if (job.place == job.count)
        I2C1->CR2 &= ~I2C_CR2_ITBUFEN; // only BTF is left to be waited for
}

static void receive_next(void)
{
    job.data[job.place++] = (uint8_t)I2C1->DR;
    if (job.place + 1 == job.count)
        I2C1->CR1 = (I2C1->CR1 & ~I2C_CR1_ACK) | I2C_CR1_STOP;
    else if (job.place == job.count)
        finish(WIRE_SUCCESS);
}

void I2C1_EV_IRQHandler(void)
{
    uint32_t status = I2C1->SR1;
    (void)I2C1->SR2;
    if (status & I2C_SR1_SB) {
        if (job.reading)
            I2C1->CR1 |= I2C_CR1_ACK;
        I2C1->CR2 |= I2C_CR2_ITBUFEN;
        I2C1->DR = (uint32_t)target << 1 | job.reading;
    } else if (status & I2C_SR1_ADDR) {
        address_was_sent();
    } else if (job.reading) {
        if (status & I2C_SR1_RXNE)
            receive_next();
    } else if (status & I2C_SR1_BTF && job.place == job.count) {
        last_was_sent();
    } else if (status & I2C_SR1_TXE) {
        send_next();
    }
}

void I2C1_ER_IRQHandler(void)
{
    uint32_t status = I2C1->SR1;
    I2C1->SR1 = 0;
    I2C1->CR1 |= I2C_CR1_STOP;
    finish(!(status & I2C_SR1_AF) ? WIRE_OTHER : job.place ? WIRE_NO_DATA : WIRE_NO_ADDRESS);
}

static void reset(void)
{
    RCC->APB1RSTR |= RCC_APB1_I2C1;
    RCC->APB1RSTR &= ~RCC_APB1_I2C1;
    I2C1->CR2 = PCLK1_HZ / 1000000;
    Wire_setClock(100000);
}

static enum wire_status carry_out(bool reading, uint8_t *data, uint32_t count, bool stop)
{
    job.data = data;
    job.count = count;
    job.place = 0;
    job.reading = reading;
    job.stop = stop;
    job.over = false;
    uint32_t begin = millis();
    while (I2C1->CR1 & I2C_CR1_STOP) { // of the message before
    }
    I2C1->CR1 |= I2C_CR1_START;
    while (I2C1->SR1 & I2C_SR1_BTF) { // of a message without STOP: it would interrupt until the START is there
    }
    I2C1->CR2 |= EVENTS;
    while (!job.over)
        if (millis() - begin > TIMEOUT_MS) {
            finish(WIRE_TIMEOUT);
            reset();
        }
    return job.status;
}

void Wire_setClock(uint32_t hz)
{
    I2C1->CR1 = 0;
    if (hz > 100000) {
        I2C1->CCR = I2C_CCR_FAST | I2C_CCR_DUTY | PCLK1_HZ / (25 * hz);
        I2C1->TRISE = PCLK1_HZ / 1000000 * 300 / 1000 + 1;
    } else {
        I2C1->CCR = PCLK1_HZ / (2 * hz);
        I2C1->TRISE = PCLK1_HZ / 1000000 + 1;
    }
    I2C1->CR1 = I2C_CR1_PE;
}

void Wire_begin(void)
{
    RCC->APB1ENR |= RCC_APB1_I2C1;
    reset();
    pinMode(PB6, ALTERNATE_OPEN_DRAIN);
    pinMode(PB7, ALTERNATE_OPEN_DRAIN);
    irq_line_enable(I2C1_EV_IRQ);
    irq_line_enable(I2C1_ER_IRQ);
}

void Wire_beginTransmission(uint8_t address)
{
    target = address;
    out_count = 0;
    too_long = false;
}

size_t Wire_write(uint8_t byte)
{
    if (out_count == WIRE_BUFFER) {
        too_long = true;
        return 0;
    }
    out[out_count++] = byte;
    return 1;
}

enum wire_status Wire_endTransmission(bool stop)
{
    return too_long ? WIRE_TOO_LONG : carry_out(false, out, out_count, stop);
}

uint8_t Wire_requestFrom(uint8_t address, uint8_t count)
{
    if (count > WIRE_BUFFER)
        count = WIRE_BUFFER;
    target = address;
    in_place = 0;
    in_count = carry_out(true, in, count, true) == WIRE_SUCCESS ? count : 0;
    return (uint8_t)in_count;
}

int Wire_read(void) { return in_place < in_count ? in[in_place++] : -1; }
