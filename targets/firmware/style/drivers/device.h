// SPDX-License-Identifier: GPL-2.0-or-later
//
// What a driver offers, behind a table of its functions; who uses a device knows its name and its kind alone.

#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "kernel.h"

struct device {
    const char *name;
    int (*init)(const struct device *device);
    const void *api, *config;
    void *data;
};

const struct device *device_get(const char *name); // none: 0

// --- kinds

#define I2C_READ 1u
#define I2C_STOP 2u

struct i2c_message {
    uint8_t *data;
    uint32_t count;
    uint32_t flags;
};

struct i2c_api {
    int (*transfer)(const struct device *device, struct i2c_message *messages, uint32_t count, uint8_t address);
};

typedef void spi_callback(const struct device *device, int result, void *argument);

struct spi_transfer {
    const uint8_t *out; // none: 0, and FF is sent
    uint8_t *in;        // none: 0
    uint32_t count;
    bool keep; // chip select stays low
};

struct spi_api {
    // The callback comes from the thread of works.
    int (*transceive)(const struct device *device, const struct spi_transfer *transfer, spi_callback *callback, void *argument);
};

struct adc_sequence {
    uint32_t channels; // a bit for each, 0 to 17
    uint16_t *buffer;
    uint32_t samplings;
    bool calibrate;
};

struct adc_api {
    int (*read)(const struct device *device, const struct adc_sequence *sequence);
};

typedef void alarm_callback(const struct device *device, uint32_t value, void *argument);

struct counter_api {
    uint32_t (*value)(const struct device *device);
    int (*set_alarm)(const struct device *device, uint32_t ticks, alarm_callback *callback, void *argument);
};

struct gpio_api {
    void (*set)(const struct device *device, uint32_t pin, bool level);
};

// --- drivers

extern const struct i2c_api i2c_stm32;
extern const struct spi_api spi_stm32;
extern const struct adc_api adc_stm32;
extern const struct counter_api rtc_stm32;

int i2c_stm32_init(const struct device *device);
int spi_stm32_init(const struct device *device);
int adc_stm32_init(const struct device *device);
int rtc_stm32_init(const struct device *device);
