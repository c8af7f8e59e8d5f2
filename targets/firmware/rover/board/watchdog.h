// SPDX-License-Identifier: GPL-2.0-or-later
//
// A program that hangs with the motors on is reset after half a second (choice).

#pragma once

void watchdog_start(void);
void watchdog_feed(void);
