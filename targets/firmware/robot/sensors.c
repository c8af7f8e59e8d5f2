// SPDX-License-Identifier: GPL-2.0-or-later
//
// The second of the validation programs: says which distance switches are on, at every change, switch 8 first. Lamp 0
// is lit while any is on.

#include "robot/robot.h"
#include "text.h"

static void say(uint8_t obstacles)
{
    struct line line = EMPTY_LINE;
    line_text(&line, "near ");
    for (int i = 7; i >= 0; --i)
        line_text(&line, obstacles >> i & 1 ? "1" : "0");
    line_text(&line, "\r\n");
    robot_say(line.text);
}

int main(void)
{
    robot_start();
    robot_connect(true);
    uint8_t said = robot_obstacles();
    say(said);
    for (;;) {
        robot_wait_tick();
        uint8_t obstacles = robot_obstacles();
        if (obstacles == said)
            continue;
        say(said = obstacles);
        robot_lamp(0, obstacles != 0);
    }
}
