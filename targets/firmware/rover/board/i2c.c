// SPDX-License-Identifier: GPL-2.0-or-later
//
// What is written goes out byte by byte, what is read is fetched by DMA.

#include "rover/board/i2c.h"

#include <stdbool.h>

#include "rover/board/time.h"
#include "rover/chip/dma.h"
#include "rover/chip/gpio.h"
#include "rover/chip/i2c.h"
#include "rover/chip/irq.h"
#include "rover/chip/rcc.h"

#define SCL 8
#define SDA 9
#define AF_I2C1 4
#define LEVEL 2
#define RX_STREAM 0 // I2C1_RX is its channel 1 (RM0410, table 27)
#define RX_CHANNEL 1

// 400 kHz from PCLK1, 54 MHz, with the analogue filter (RM0410, 33.4.5 and 33.4.9): a step of 3 / 54 MHz = 56 ns; SCL low for
// 24 steps, 1.33 us, and high for 16, 0.89 us, and what it takes to see both edges; data held for 4 and set up for 8.
#define TIMING                                                                                                          \
    (2u << I2C_TIMINGR_PRESC_SHIFT | 7u << I2C_TIMINGR_SCLDEL_SHIFT | 4u << I2C_TIMINGR_SDADEL_SHIFT |                  \
     15u << I2C_TIMINGR_SCLH_SHIFT | 23u)

#define INTERRUPTS (I2C_CR1_TXIE | I2C_CR1_NACKIE | I2C_CR1_STOPIE | I2C_CR1_TCIE | I2C_CR1_ERRIE)

static volatile enum i2c_state state = I2C_DONE;
static uint8_t to_write[2]; // register, value
static uint8_t written;
static uint8_t *to_read;
static uint8_t read_count;
static uint32_t slave; // the field of CR2
static bool refused;

static void address(uint32_t count, uint32_t more)
{
    I2C1->CR2 = slave | count << I2C_CR2_NBYTES_SHIFT | more | I2C_CR2_START;
}

static void begin(uint8_t device, uint8_t reg, uint8_t *to, uint8_t count)
{
    dma_stop(RX_STREAM); // a transfer that was refused or hung may have left it waiting
    slave = (uint32_t)device << I2C_CR2_ADDRESS_SHIFT;
    to_write[0] = reg;
    written = 0;
    to_read = to;
    read_count = count;
    refused = false;
    state = I2C_BUSY;
}

void i2c_write(uint8_t device, uint8_t reg, uint8_t value)
{
    begin(device, reg, 0, 0);
    to_write[1] = value;
    address(2, I2C_CR2_AUTOEND);
}

// The register's number first, then a repeated start: AUTOEND is off, so that TC comes instead of a stop.
void i2c_read(uint8_t device, uint8_t reg, uint8_t *to, uint8_t count)
{
    begin(device, reg, to, count);
    address(1, 0);
}

enum i2c_state i2c_state(void) { return state; }

void I2C1_EV_IRQHandler(void)
{
    uint32_t flags = I2C1->ISR;
    if (flags & I2C_NACKF) { // a stop follows by itself
        I2C1->ICR = I2C_NACKF;
        refused = true;
    }
    if (flags & I2C_TXIS)
        I2C1->TXDR = to_write[written++ % sizeof to_write];
    if (flags & I2C_TC) {
        dma_begin(RX_STREAM, RX_CHANNEL, &I2C1->RXDR, to_read, read_count, 0);
        address(read_count, I2C_CR2_READ | I2C_CR2_AUTOEND);
    }
    if (flags & I2C_STOPF) {
        I2C1->ICR = I2C_STOPF;
        state = refused ? I2C_FAILED : I2C_DONE;
    }
}

void I2C1_ER_IRQHandler(void)
{
    I2C1->ICR = I2C_ERRORS;
    state = I2C_FAILED;
}

static void enable(void)
{
    I2C1->CR1 = 0; // resets its state machine, too
    I2C1->TIMINGR = TIMING;
    I2C1->CR1 = I2C_CR1_PE | I2C_CR1_RXDMAEN | INTERRUPTS;
}

void i2c_start(void)
{
    RCC->AHB1ENR |= RCC_AHB1_GPIO('B') | RCC_AHB1_DMA1;
    RCC->APB1ENR |= RCC_APB1_I2C1;
    for (unsigned pin = SCL; pin <= SDA; ++pin) {
        pin_open_drain(GPIO('B'), pin);
        pin_pull_up(GPIO('B'), pin);
        pin_alternate(GPIO('B'), pin, AF_I2C1);
    }
    enable();
    irq_enable_line(I2C1_EV_IRQ, LEVEL);
    irq_enable_line(I2C1_ER_IRQ, LEVEL);
}

static void wait_us(uint32_t span_us)
{
    uint32_t start_us = time_us();
    while (time_us() - start_us < span_us) {
    }
}

// A slave in the middle of a byte needs at most nine clocks to its end (UM10204, 3.1.16).
void i2c_recover(void)
{
    I2C1->CR1 = 0;
    pin_write(GPIO('B'), SCL, true);
    pin_mode(GPIO('B'), SCL, PIN_OUTPUT);
    for (unsigned clock = 0; clock < 9 && !pin_read(GPIO('B'), SDA); ++clock) {
        pin_write(GPIO('B'), SCL, false);
        wait_us(5);
        pin_write(GPIO('B'), SCL, true);
        wait_us(5);
    }
    pin_alternate(GPIO('B'), SCL, AF_I2C1);
    enable();
    state = I2C_FAILED;
}
