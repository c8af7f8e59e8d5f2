// SPDX-License-Identifier: GPL-2.0-or-later
//
// Drives forward while any distance switch is on, and stands while none is.

#include "robot/robot.h"

int main(void)
{
    robot_start();
    robot_connect(true);
    for (;;) {
        int code = robot_obstacles() ? 3 : 0;
        robot_drive(code, code);
        robot_wait_tick();
    }
}
