// SPDX-License-Identifier: GPL-2.0-or-later
//
// Pins (RM0433, section 11.4), one at a time.

#pragma once

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint32_t MODER;
    uint32_t OTYPER;
    uint32_t OSPEEDR;
    uint32_t PUPDR;
    uint32_t IDR;
    uint32_t ODR;
    uint32_t BSRR;
    uint32_t LCKR;
    uint32_t AFR[2];
} gpio_t;

typedef volatile gpio_t *port_t;

#define GPIO(letter) ((port_t)(0x58020000u + 0x400u * ((letter) - 'A')))

enum pin_mode { PIN_INPUT, PIN_OUTPUT, PIN_ALTERNATE, PIN_ANALOG };

static inline void pin_field(volatile uint32_t *reg, unsigned pin, unsigned value)
{
    *reg = (*reg & ~(3u << 2 * pin)) | value << 2 * pin;
}

static inline void pin_mode(port_t port, unsigned pin, enum pin_mode mode) { pin_field(&port->MODER, pin, mode); }

// Before the mode, so that the pin never belongs to the wrong peripheral.
static inline void pin_alternate(port_t port, unsigned pin, unsigned function)
{
    volatile uint32_t *reg = &port->AFR[pin / 8];
    unsigned shift = pin % 8 * 4;
    *reg = (*reg & ~(0xFu << shift)) | function << shift;
    pin_mode(port, pin, PIN_ALTERNATE);
}

static inline void pin_pull_up(port_t port, unsigned pin) { pin_field(&port->PUPDR, pin, 1); }

static inline void pin_write(port_t port, unsigned pin, bool level) { port->BSRR = 1u << (level ? pin : pin + 16); }
