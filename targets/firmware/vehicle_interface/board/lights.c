// SPDX-License-Identifier: GPL-2.0-or-later

#include "vehicle_interface/board/lights.h"

#include "vehicle_interface/chip/gpio.h"
#include "vehicle_interface/chip/rcc.h"

static const struct {
    char port;
    uint8_t pin;
} PINS[LIGHTS] = {
    [LIGHT_MANUAL] = {'B', 0}, [LIGHT_AUTOWARE] = {'E', 1}, [LIGHT_EMERGENCY] = {'B', 14},
    [LAMP_LEFT] = {'E', 7},    [LAMP_RIGHT] = {'E', 8},
};

void lights_start(void)
{
    RCC->AHB4ENR |= RCC_AHB4_GPIO('B') | RCC_AHB4_GPIO('E');
    (void)RCC->AHB4ENR;
    for (unsigned light = 0; light < LIGHTS; ++light)
        pin_mode(GPIO(PINS[light].port), PINS[light].pin, PIN_OUTPUT);
}

void light_put(enum light light, bool on) { pin_write(GPIO(PINS[light].port), PINS[light].pin, on); }
