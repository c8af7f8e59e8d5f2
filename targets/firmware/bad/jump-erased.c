// SPDX-License-Identifier: GPL-2.0-or-later
//
// A call into flash memory that was never programmed, 0x0800F000: as a boot loader would do without an application. Erased
// memory reads 0xFFFF, which is no instruction, and faults.

#include "bad.h"
#include <stdint.h>

__attribute__((noinline)) static void call_application(void) { ((void (*)(void))(uintptr_t)0x0800F001u)(); }

int main(void)
{
    alive("jump-erased\r\n");
    call_application();
    return 0;
}
