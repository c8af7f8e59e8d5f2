// SPDX-License-Identifier: GPL-2.0-or-later
//
// Images that go wrong on purpose, each in its own way, so that what is said about it can be tested. All of them first
// light the LED and print one line over USART1 (PA9, 115200 8N1), as proof of life; then main falls into the function
// that the diagnosis should name.

#pragma once

void alive(const char *line); // the chip runs on HSI, 8 MHz, all the time
