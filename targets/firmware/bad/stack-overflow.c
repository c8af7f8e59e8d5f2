// SPDX-License-Identifier: GPL-2.0-or-later
//
// A recursion without end: the stack grows below the start of RAM, where not even the frame of a fault can be pushed.

#include "bad.h"
#include <stdint.h>

__attribute__((noinline)) static uint32_t recurse(uint32_t depth)
{
    volatile uint32_t here[16];
    if (depth == UINT32_MAX)
        return 0; // it never gets there
    here[depth % 16] = depth;
    return recurse(depth + 1) + here[depth % 16];
}

int main(void)
{
    alive("stack-overflow\r\n");
    return (int)recurse(0);
}
