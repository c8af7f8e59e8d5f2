// SPDX-License-Identifier: GPL-2.0-or-later
//
// Numbers as text.

#pragma once

#define NUMBER_BYTES 32

// Write a number from 0 up to a million with 15 decimal places, as far as a double has them.
void number_write(char text[NUMBER_BYTES], double value);
