// SPDX-License-Identifier: GPL-2.0-or-later
//
// Built with -fno-tree-loop-distribute-patterns, or GCC would turn each of these loops into a call of itself.

#include "memory.h"

void *memcpy(void *restrict to, const void *restrict from, size_t count)
{
    char *t = to;
    const char *f = from;
    while (count--)
        *t++ = *f++;
    return to;
}

void *memmove(void *to, const void *from, size_t count)
{
    char *t = to;
    const char *f = from;
    if (t < f)
        return memcpy(to, from, count);
    while (count--)
        t[count] = f[count];
    return to;
}

void *memset(void *to, int value, size_t count)
{
    char *t = to;
    while (count--)
        *t++ = (char)value;
    return to;
}

int memcmp(const void *a, const void *b, size_t count)
{
    const unsigned char *x = a, *y = b;
    for (; count--; ++x, ++y)
        if (*x != *y)
            return *x - *y;
    return 0;
}
