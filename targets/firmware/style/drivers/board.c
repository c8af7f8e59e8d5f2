// SPDX-License-Identifier: GPL-2.0-or-later
//
// Which devices there are. They are made ready in this order, before the threads.

#include "board.h"

#include "chip/stm32f103.h"
#include "device.h"
#include "pin.h"

static int gpio_init(const struct device *device)
{
    port_t port = *(const port_t *)device->config;
    RCC->APB2ENR |= port == GPIOA ? RCC_APB2_GPIOA : port == GPIOB ? RCC_APB2_GPIOB : RCC_APB2_GPIOC;
    return 0;
}

static void gpio_set(const struct device *device, uint32_t pin, bool level)
{
    port_t port = *(const port_t *)device->config;
    pin_write(port, pin, level);
    pin_mode(port, pin, PIN_OUTPUT);
}

static const struct gpio_api gpio_stm32 = {gpio_set};
static const port_t gpioa = GPIOA, gpiob = GPIOB, gpioc = GPIOC;

static const struct {
    const char *gpio;
    uint32_t select;
} flash_select = {"gpioa", 4};

static int pins_init(const struct device *device)
{
    (void)device;
    pin_mode(GPIOA, 0, PIN_ANALOG);
    pin_mode(GPIOA, 1, PIN_ANALOG);
    pin_mode(GPIOA, 5, PIN_ALTERNATE);
    pin_pull(GPIOA, 6, true);
    pin_mode(GPIOA, 7, PIN_ALTERNATE);
    pin_mode(GPIOB, 6, PIN_ALTERNATE_OPEN_DRAIN);
    pin_mode(GPIOB, 7, PIN_ALTERNATE_OPEN_DRAIN);
    return 0;
}

static const struct device devices[] = {
    {.name = "gpioa", .init = gpio_init, .api = &gpio_stm32, .config = &gpioa},
    {.name = "gpiob", .init = gpio_init, .api = &gpio_stm32, .config = &gpiob},
    {.name = "gpioc", .init = gpio_init, .api = &gpio_stm32, .config = &gpioc},
    {.name = "pins", .init = pins_init},
    {.name = "i2c1", .init = i2c_stm32_init, .api = &i2c_stm32},
    {.name = "spi1", .init = spi_stm32_init, .api = &spi_stm32, .config = &flash_select},
    {.name = "adc1", .init = adc_stm32_init, .api = &adc_stm32},
    {.name = "rtc", .init = rtc_stm32_init, .api = &rtc_stm32},
};

#define DEVICES (sizeof devices / sizeof *devices)

void devices_init(void)
{
    for (uint32_t at = 0; at < DEVICES; ++at)
        devices[at].init(&devices[at]);
}

static bool same(const char *one, const char *other)
{
    for (; *one == *other; ++one, ++other)
        if (!*one)
            return true;
    return false;
}

const struct device *device_get(const char *name)
{
    for (uint32_t at = 0; at < DEVICES; ++at)
        if (same(devices[at].name, name))
            return &devices[at];
    return 0;
}
