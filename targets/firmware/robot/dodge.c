// SPDX-License-Identifier: GPL-2.0-or-later
//
// The fourth of the validation programs: finds its way between obstacles by a finite state machine.
//
//   FORWARD   until something is near ahead, or half to a side
//   TURN      on the spot, away from the side where more is near, until the way ahead has been free for a while
//   BACK      a little, first, if something is near on both sides: over ground that was just driven over
//
// Every state has codes of its own, so that it can be seen at the wires. It is said over USART1 too.

#include "robot/robot.h"

#define AHEAD 0x3Cu       // distance switches 3 to 6: 30 degrees to either side
#define HALF_LEFT 0x02u   // 50 degrees
#define HALF_RIGHT 0x40u  // likewise
#define LEFT_SIDE 0x0Fu   // switches 1 to 4
#define RIGHT_SIDE 0xF0u  // switches 5 to 8
#define FAR_LEFT 0x01u    // 90 degrees
#define FAR_RIGHT 0x80u   // likewise

#define FREE_MS 300u      // the way ahead must have been free for so long
#define BACK_MS 500u
#define RUN_UP_MS 1500u   // and only after so long forward is it certain that there is room behind

#ifndef BLIND
#define BLIND 0u          // switches that are not looked at
#endif
#ifndef STUCK
#define STUCK 0           // 1: never leaves a turn
#endif

enum state { FORWARD, TURN_LEFT, TURN_RIGHT, BACK };

static const struct {
    int left, right;
    const char *name;
} STATES[] = {
    [FORWARD] = {3, 3, "forward\r\n"},
    [TURN_LEFT] = {-3, 3, "left\r\n"},
    [TURN_RIGHT] = {3, -3, "right\r\n"},
    [BACK] = {-4, -4, "back\r\n"},
};

static enum state state;
static uint32_t since_ms; // in this state
static uint32_t free_ms;  // nothing ahead since

static void enter(enum state next)
{
    state = next;
    since_ms = free_ms = robot_now_ms();
    robot_drive(STATES[next].left, STATES[next].right);
    robot_say(STATES[next].name);
}

static int ones(uint8_t word) { return __builtin_popcount(word); }

static enum state away_from(uint8_t near)
{
    return ones(near & LEFT_SIDE) > ones(near & RIGHT_SIDE) ? TURN_RIGHT : TURN_LEFT;
}

static bool blocked(uint8_t near) { return near & (AHEAD | HALF_LEFT | HALF_RIGHT); }

static bool both_sides(uint8_t near)
{
    return near & (HALF_LEFT | FAR_LEFT) && near & (HALF_RIGHT | FAR_RIGHT) && near & AHEAD;
}

static void step(uint8_t near)
{
    uint32_t now_ms = robot_now_ms(), spent_ms = now_ms - since_ms;
    if (blocked(near))
        free_ms = now_ms;
    switch (state) {
    case FORWARD:
        if (both_sides(near) && spent_ms >= RUN_UP_MS)
            enter(BACK);
        else if (blocked(near))
            enter(away_from(near));
        break;
    case TURN_LEFT:
    case TURN_RIGHT:
        if (!STUCK && now_ms - free_ms >= FREE_MS)
            enter(FORWARD);
        break;
    case BACK:
        if (spent_ms >= BACK_MS)
            enter(away_from(near));
        break;
    }
}

int main(void)
{
    robot_start();
    robot_connect(true);
    enter(FORWARD);
    for (;;) {
        robot_wait_tick();
        step(robot_obstacles() & (uint8_t)~BLIND);
    }
}
