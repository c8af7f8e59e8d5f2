// SPDX-License-Identifier: GPL-2.0-or-later
//
// I2C with a TIMINGR (RM0410, section 33), as a master of 7-bit addresses.

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t CR1;
    uint32_t CR2;
    uint32_t OAR1;
    uint32_t OAR2;
    uint32_t TIMINGR;
    uint32_t TIMEOUTR;
    uint32_t ISR;
    uint32_t ICR;
    uint32_t PECR;
    uint32_t RXDR;
    uint32_t TXDR;
} i2c_t;

#define I2C1 ((volatile i2c_t *)0x40005400u)

#define I2C_CR1_PE (1u << 0)
#define I2C_CR1_TXIE (1u << 1)
#define I2C_CR1_NACKIE (1u << 4)
#define I2C_CR1_STOPIE (1u << 5)
#define I2C_CR1_TCIE (1u << 6)
#define I2C_CR1_ERRIE (1u << 7)
#define I2C_CR1_RXDMAEN (1u << 15)

#define I2C_CR2_ADDRESS_SHIFT 1
#define I2C_CR2_READ (1u << 10)
#define I2C_CR2_START (1u << 13)
#define I2C_CR2_NBYTES_SHIFT 16
#define I2C_CR2_AUTOEND (1u << 25)

#define I2C_TXIS (1u << 1) // bits of ISR; ICR has the ones that can be cleared at the same places
#define I2C_NACKF (1u << 4)
#define I2C_STOPF (1u << 5)
#define I2C_TC (1u << 6)
#define I2C_BERR (1u << 8)
#define I2C_ARLO (1u << 9)
#define I2C_OVR (1u << 10)
#define I2C_ERRORS (I2C_BERR | I2C_ARLO | I2C_OVR)

#define I2C_TIMINGR_PRESC_SHIFT 28
#define I2C_TIMINGR_SCLDEL_SHIFT 20
#define I2C_TIMINGR_SDADEL_SHIFT 16
#define I2C_TIMINGR_SCLH_SHIFT 8
