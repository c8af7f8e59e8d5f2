// SPDX-License-Identifier: GPL-2.0-or-later
//
// The first of the validation programs: both motors at 0, 3, -4 and 0 again.

#include "robot/robot.h"

#define LEG_MS 3000u

static void leg(int code, const char *said)
{
    robot_say(said);
    robot_drive(code, code);
    robot_wait_ms(LEG_MS);
}

int main(void)
{
    robot_start();
    robot_connect(true);
    leg(0, "0\r\n");
    leg(3, "3\r\n");
    leg(-4, "-4\r\n");
    leg(0, "0\r\n");
    for (;;)
        robot_wait_tick();
}
