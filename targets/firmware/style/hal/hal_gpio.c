// SPDX-License-Identifier: GPL-2.0-or-later

#include "hal.h"

void hal_gpio_init(volatile gpio_t *port, uint16_t pins, uint32_t mode, bool pull_up)
{
    for (unsigned pin = 0; pin < 16; ++pin) {
        if (!(pins & 1u << pin))
            continue;
        volatile uint32_t *cr = &port->CR[pin / 8];
        unsigned shift = pin % 8 * 4;
        if (mode == PIN_PULLED)
            *(pull_up ? &port->BSRR : &port->BRR) = 1u << pin;
        *cr = (*cr & ~(0xFu << shift)) | mode << shift;
    }
}

void hal_gpio_write(volatile gpio_t *port, uint16_t pins, bool level) { port->BSRR = level ? pins : (uint32_t)pins << 16; }

void hal_gpio_toggle(volatile gpio_t *port, uint16_t pins)
{
    uint32_t odr = port->ODR;
    port->BSRR = (odr & pins) << 16 | (~odr & pins);
}
