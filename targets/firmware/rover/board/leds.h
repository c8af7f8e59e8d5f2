// SPDX-License-Identifier: GPL-2.0-or-later
//
// The board's three lights (UM1974, 6.5), on while their pins are high.

#pragma once

#include <stdbool.h>

enum led {
    LED_TEST,  // LD1, green, PB0: what LED_ON and LED_OFF switch
    LED_ALIVE, // LD2, blue, PB7
    LED_ALARM, // LD3, red, PB14
    LEDS,
};

void leds_start(void);
void led_put(enum led led, bool on);
void led_toggle(enum led led);
