// SPDX-License-Identifier: GPL-2.0-or-later
//
// Drives forward and then does nothing any more: what becomes of a robot whose program has stopped?

#include "chip/stm32f103.h"
#include "robot/robot.h"

int main(void)
{
    robot_start();
    robot_connect(true);
    robot_drive(3, 3);
    robot_wait_ms(5000);
    irq_disable();
    for (;;) {
    }
}
