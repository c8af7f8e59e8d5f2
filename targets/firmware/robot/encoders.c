// SPDX-License-Identifier: GPL-2.0-or-later
//
// The third of the validation programs: drives slowly, one turn of the wheels and more forwards, then backwards, and
// says what the encoders show at every change.

#include "robot/robot.h"
#include "text.h"

#define LEG_MS 11000u

static void say(unsigned left, unsigned right)
{
    struct line line = EMPTY_LINE;
    line_text(&line, "left ");
    line_decimal(&line, left);
    line_text(&line, " right ");
    line_decimal(&line, right);
    line_text(&line, "\r\n");
    robot_say(line.text);
}

static void leg(int code, uint32_t span_ms)
{
    static unsigned said = ~0u;
    uint32_t end_ms = robot_now_ms() + span_ms;
    robot_drive(code, code);
    while ((int32_t)(robot_now_ms() - end_ms) < 0) {
        unsigned left = robot_encoder(LEFT), right = robot_encoder(RIGHT);
        if (said != (left << 3 | right)) {
            said = left << 3 | right;
            say(left, right);
        }
        robot_wait_tick();
    }
}

int main(void)
{
    robot_start();
    robot_connect(true);
    leg(0, 1500);
    leg(1, LEG_MS);
    leg(0, 1500);
    leg(-1, LEG_MS);
    for (;;)
        leg(0, LEG_MS);
}
