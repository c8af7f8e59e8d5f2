// SPDX-License-Identifier: GPL-2.0-or-later
//
// Numbers as text, and text put together, in a buffer of one line.

#pragma once

#include <stddef.h>
#include <stdint.h>

#define LINE_BYTES 120

// A line under construction, always terminated; what does not fit is left out.
struct line {
    size_t length;
    char text[LINE_BYTES];
};

#define EMPTY_LINE ((struct line){.length = 0})

void line_text(struct line *line, const char *text);
void line_decimal(struct line *line, uint32_t value);
void line_hex(struct line *line, uint32_t value); // 0x and as many digits as it takes
