// SPDX-License-Identifier: GPL-2.0-or-later
//
// Catching faults: a cause is called, and whatever fault it meets ends it and is noted. Whoever includes this gets handlers
// for all four faults.

#pragma once

#include <stdint.h>

// What the last fault was; `exception` is 0 if there was none.
struct caught {
    uint32_t exception, cfsr, hfsr, bfar, pc, exc_return;
};

extern volatile struct caught caught;

void provoke(void (*cause)(uint32_t), uint32_t argument);

// The instruction that faults is the first of its function, so the address of the one is that of the other.
#define CAUSE(name, instruction)                                                                                        \
    static __attribute__((naked)) void name(uint32_t argument)                                                          \
    {                                                                                                                   \
        (void)argument;                                                                                                 \
        __asm volatile(instruction "\n bx lr");                                                                         \
    }

static inline uint32_t address_of(void (*cause)(uint32_t)) { return (uint32_t)(uintptr_t)cause & ~1u; }

// A check that the fault caught last was this one.
void expect_caught(const char *name, uint32_t exception, uint32_t cfsr, uint32_t pc);
