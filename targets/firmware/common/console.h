// SPDX-License-Identifier: GPL-2.0-or-later
//
// Where the self-tests print: to the debugger when built with SEMIHOSTING=1, else to USART1 (PA9, 115200 8N1).

#pragma once

#include <stdint.h>

// Prints the text whole. USART1, PA9 and their clocks are borrowed for it and given back as they were, whatever the
// clock tree is set to, so that a test may use them for itself between two lines.
void console_write(const char *text);

// Ends the program. With semihosting the debugger gets the status; on a board alone it stays here, the LED on PC13 lit
// for good if the status is 0 and blinking if not.
__attribute__((noreturn)) void console_exit(uint32_t status);
