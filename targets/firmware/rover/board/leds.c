// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/board/leds.h"

#include "rover/chip/gpio.h"
#include "rover/chip/rcc.h"

static const uint8_t PINS[LEDS] = {[LED_TEST] = 0, [LED_ALIVE] = 7, [LED_ALARM] = 14};

void leds_start(void)
{
    RCC->AHB1ENR |= RCC_AHB1_GPIO('B');
    for (unsigned led = 0; led < LEDS; ++led)
        pin_mode(GPIO('B'), PINS[led], PIN_OUTPUT);
}

void led_put(enum led led, bool on) { pin_write(GPIO('B'), PINS[led], on); }

void led_toggle(enum led led) { led_put(led, !(GPIO('B')->ODR >> PINS[led] & 1u)); }
