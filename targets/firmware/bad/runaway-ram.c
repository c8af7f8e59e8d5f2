// SPDX-License-Identifier: GPL-2.0-or-later
//
// A jump into RAM that holds no code. At 0x20004000 there are 2 KB of zeros, each of them an instruction that does nothing
// (movs r0, r0), and then one that is undefined.

#include "bad.h"

#include <stdint.h>

#define JUNK 0x20004000u
#define JUNK_END 0x20004800u

__attribute__((noinline)) static void call_junk(void) { ((void (*)(void))(uintptr_t)(JUNK | 1))(); }

int main(void)
{
    alive("runaway-ram\r\n");
    for (volatile uint32_t *at = (volatile uint32_t *)JUNK; at < (volatile uint32_t *)JUNK_END; ++at)
        *at = 0;
    *(volatile uint16_t *)JUNK_END = 0xDE00; // udf #0
    call_junk();
    return 0;
}
