// SPDX-License-Identifier: GPL-2.0-or-later
//
// I2C interfaces (RM0008, section 26), with their gates (7.3.8) and DMA channels (table 78).

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t CR1;
    uint32_t CR2;
    uint32_t OAR1;
    uint32_t OAR2;
    uint32_t DR;
    uint32_t SR1;
    uint32_t SR2;
    uint32_t CCR;
    uint32_t TRISE;
} i2c_t;

#define I2C1 ((volatile i2c_t *)0x40005400u)
#define I2C2 ((volatile i2c_t *)0x40005800u)

#define RCC_APB1_I2C1 (1u << 21)
#define RCC_APB1_I2C2 (1u << 22)
#define DMA_I2C1_TX 6
#define DMA_I2C1_RX 7

#define I2C_CR1_PE (1u << 0)
#define I2C_CR1_START (1u << 8)
#define I2C_CR1_STOP (1u << 9)
#define I2C_CR1_ACK (1u << 10)
#define I2C_CR1_POS (1u << 11)
#define I2C_CR1_SWRST (1u << 15)

#define I2C_CR2_ITERREN (1u << 8)
#define I2C_CR2_ITEVTEN (1u << 9)
#define I2C_CR2_ITBUFEN (1u << 10)
#define I2C_CR2_DMAEN (1u << 11)
#define I2C_CR2_LAST (1u << 12)

#define I2C_SR1_SB (1u << 0)
#define I2C_SR1_ADDR (1u << 1)
#define I2C_SR1_BTF (1u << 2)
#define I2C_SR1_RXNE (1u << 6)
#define I2C_SR1_TXE (1u << 7)
#define I2C_SR1_ARLO (1u << 9)
#define I2C_SR1_AF (1u << 10)

#define I2C_SR2_MSL (1u << 0)
#define I2C_SR2_BUSY (1u << 1)
#define I2C_SR2_TRA (1u << 2)

#define I2C_CCR_FAST (1u << 15)
#define I2C_CCR_DUTY (1u << 14)
