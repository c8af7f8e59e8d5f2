// SPDX-License-Identifier: GPL-2.0-or-later
//
// A fault in the HardFault handler: the core locks up (DDI 0403, B1.5.15).

#include "bad.h"
#include "handlers.h"

void HardFault_Handler(void) { *(volatile unsigned *)0x60000004 = 1; }

__attribute__((noinline)) static void execute_undefined(void) { __asm volatile("udf #0"); }

int main(void)
{
    alive("lockup\r\n");
    execute_undefined();
    return 0;
}
