// SPDX-License-Identifier: GPL-2.0-or-later
//
// A load from where nothing is. The HardFault handler returns to the very same instruction, for ever.

#include "bad.h"
#include "handlers.h"

void HardFault_Handler(void) {}

__attribute__((noinline)) static unsigned read_from_nowhere(void) { return *(volatile unsigned *)0x60000000; }

int main(void)
{
    alive("hardfault-loop\r\n");
    return (int)read_from_nowhere();
}
