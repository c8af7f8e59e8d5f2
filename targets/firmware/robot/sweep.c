// SPDX-License-Identifier: GPL-2.0-or-later
//
// All 64 pairs of codes, each for a while, with a stop before it.

#include "robot/robot.h"
#include "text.h"

#ifndef HOLD_MS
#define HOLD_MS 300u
#endif

static void say(int left, int right)
{
    struct line line = EMPTY_LINE;
    line_text(&line, left < 0 ? "-" : "");
    line_decimal(&line, (uint32_t)(left < 0 ? -left : left));
    line_text(&line, right < 0 ? " -" : " ");
    line_decimal(&line, (uint32_t)(right < 0 ? -right : right));
    line_text(&line, "\r\n");
    robot_say(line.text);
}

int main(void)
{
    robot_start();
    robot_connect(true);
    robot_wait_ms(2000);
    for (int left = CODE_LEAST; left <= CODE_MOST; ++left) {
        for (int right = CODE_LEAST; right <= CODE_MOST; ++right) {
            say(left, right);
            robot_drive(left, right);
            robot_wait_ms(HOLD_MS);
        }
    }
    robot_drive(0, 0);
    robot_say("done\r\n");
    for (;;)
        robot_wait_tick();
}
