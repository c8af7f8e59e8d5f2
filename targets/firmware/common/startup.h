// SPDX-License-Identifier: GPL-2.0-or-later
//
// What startup.c offers to the rest: the vector table, and what the core pushes when it takes an exception.

#pragma once

#include <stdint.h>

#define VECTOR_COUNT (16 + 43)

// DDI 0403, B1.5.6
struct exception_frame {
    uint32_t r0, r1, r2, r3, r12, lr, pc, xpsr;
};

void unhandled_exception(const struct exception_frame *frame);

// A variable that a reset leaves alone: random after power-up, kept after any other reset.
#define NOINIT __attribute__((section(".noinit")))

// A function that runs from RAM, as one must that looks on while the flash memory is busy.
#define RAM_FUNCTION __attribute__((section(".ramfunc"), long_call, noinline))
