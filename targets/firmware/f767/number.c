// SPDX-License-Identifier: GPL-2.0-or-later

#include "f767/number.h"

#include <stdint.h>

#define PLACES 15

static char *write_digits(char *end, uint32_t whole)
{
    char digits[10];
    int count = 0;
    do
        digits[count++] = (char)('0' + whole % 10);
    while (whole /= 10);
    while (count)
        *end++ = digits[--count];
    return end;
}

void number_write(char text[NUMBER_BYTES], double value)
{
    uint32_t whole = (uint32_t)value;
    double rest = value - (double)whole;
    char *end = write_digits(text, whole);
    *end++ = '.';
    for (int place = 0; place < PLACES; ++place) {
        rest *= 10;
        uint32_t digit = (uint32_t)rest;
        *end++ = (char)('0' + digit);
        rest -= (double)digit;
    }
    *end = 0;
}
