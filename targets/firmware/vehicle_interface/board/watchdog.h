// SPDX-License-Identifier: GPL-2.0-or-later
//
// A task that hangs while the car drives: the chip is reset after half a second in which not both tasks were alive (choice;
// the original has no watchdog).

#pragma once

enum who { ALIVE_CONTROL = 1, ALIVE_STACK = 2, ALIVE_ALL = 3 };

#define ALIVE_TICKS 200u // the longest that a task may be silent

void watchdog_start(void);

// Feeds it as soon as all have called.
void watchdog_alive(enum who who);
