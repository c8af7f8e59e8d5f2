// SPDX-License-Identifier: GPL-2.0-or-later
//
// One pin at a time.

#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "chip/gpio.h"

typedef volatile gpio_t *port_t;

static inline void pin_mode(port_t port, unsigned pin, enum pin_mode mode)
{
    unsigned shift = pin % 8 * 4;
    port->CR[pin / 8] = (port->CR[pin / 8] & ~(0xFu << shift)) | (uint32_t)mode << shift;
}

static inline void pin_write(port_t port, unsigned pin, bool level) { port->BSRR = 1u << (level ? pin : pin + 16); }

static inline void pin_toggle(port_t port, unsigned pin) { pin_write(port, pin, !(port->ODR >> pin & 1u)); }

static inline bool pin_read(port_t port, unsigned pin) { return port->IDR >> pin & 1u; }

// Makes the pin an input that its own pull-up or pull-down sets; pin_write then moves its level with no wire attached.
static inline void pin_pull(port_t port, unsigned pin, bool up)
{
    pin_write(port, pin, up);
    pin_mode(port, pin, PIN_PULLED);
}
