// SPDX-License-Identifier: GPL-2.0-or-later
//
// A mistake that is easily made: the wires of the right motor are written, but their pins were left inputs.

#include "chip/stm32f103.h"
#include "pin.h"
#include "robot/robot.h"

int main(void)
{
    robot_start();
    robot_connect(true);
    for (unsigned pin = 1; pin <= 3; ++pin)
        pin_mode(GPIOA, pin, PIN_FLOATING);
    GPIOA->ODR |= 0x06;
    robot_motor(LEFT, 3);
    for (;;)
        robot_wait_tick();
}
