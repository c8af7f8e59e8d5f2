// SPDX-License-Identifier: GPL-2.0-or-later
//
// What SMBus and slaves need of an I2C interface besides "chip/i2c.h" (RM0008, section 26.6).

#pragma once

#include "chip/i2c.h"

#define DMA_I2C2_TX 4
#define DMA_I2C2_RX 5

#define I2C_CR1_SMBUS (1u << 1)
#define I2C_CR1_SMBTYPE (1u << 3)
#define I2C_CR1_ENARP (1u << 4)
#define I2C_CR1_ENPEC (1u << 5)
#define I2C_CR1_ENGC (1u << 6)
#define I2C_CR1_NOSTRETCH (1u << 7)
#define I2C_CR1_PEC (1u << 12)
#define I2C_CR1_ALERT (1u << 13)

#define I2C_OAR1_ALWAYS (1u << 14)
#define I2C_OAR1_ADDMODE (1u << 15)
#define I2C_OAR2_ENDUAL (1u << 0)

#define I2C_SR1_ADD10 (1u << 3)
#define I2C_SR1_STOPF (1u << 4)
#define I2C_SR1_OVR (1u << 11)
#define I2C_SR1_PECERR (1u << 12)
#define I2C_SR1_TIMEOUT (1u << 14)
#define I2C_SR1_SMBALERT (1u << 15)

#define I2C_SR2_GENCALL (1u << 4)
#define I2C_SR2_SMBDEFAULT (1u << 5)
#define I2C_SR2_SMBHOST (1u << 6)
#define I2C_SR2_DUALF (1u << 7)
#define I2C_SR2_PEC_SHIFT 8
