// SPDX-License-Identifier: GPL-2.0-or-later

#include "text.h"

void line_text(struct line *line, const char *text)
{
    while (*text && line->length < LINE_BYTES - 1)
        line->text[line->length++] = *text++;
    line->text[line->length] = 0;
}

static void number(struct line *line, uint32_t value, uint32_t base)
{
    char digits[11];
    char *at = digits + sizeof digits - 1;
    *at = 0;
    do {
        *--at = "0123456789abcdef"[value % base];
        value /= base;
    } while (value);
    line_text(line, at);
}

void line_decimal(struct line *line, uint32_t value) { number(line, value, 10); }

void line_hex(struct line *line, uint32_t value)
{
    line_text(line, "0x");
    number(line, value, 16);
}
