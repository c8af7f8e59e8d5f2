// SPDX-License-Identifier: GPL-2.0-or-later
//
// I2C1 (SCL PB8, SDA PB9) as a master, 400 kHz. One transfer at a time, which interrupts carry out: nobody ever waits. A slave
// or a bus that hangs is the caller's to notice and to end, with i2c_recover.

#pragma once

#include <stdint.h>

enum i2c_state { I2C_BUSY, I2C_DONE, I2C_FAILED };

void i2c_start(void);

void i2c_write(uint8_t address, uint8_t reg, uint8_t value);
void i2c_read(uint8_t address, uint8_t reg, uint8_t *to, uint8_t count);

// Of the transfer begun last.
enum i2c_state i2c_state(void);

// Ends the transfer, lets a slave that holds SDA go on until it lets go, and begins anew.
void i2c_recover(void);
