// SPDX-License-Identifier: GPL-2.0-or-later
//
// A call of an address where nothing is, as by a function pointer that was overwritten.

#include "bad.h"
#include <stdint.h>

__attribute__((noinline)) static void call_nowhere(void) { ((void (*)(void))(uintptr_t)0x30000001u)(); }

int main(void)
{
    alive("runaway-nowhere\r\n");
    call_nowhere();
    return 0;
}
