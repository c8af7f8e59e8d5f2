// SPDX-License-Identifier: GPL-2.0-or-later
//
// Instructions that C has no word for.

#pragma once

#include <stdint.h>

#define WFI() __asm volatile("wfi" ::: "memory")
#define WFE() __asm volatile("wfe" ::: "memory")
#define SEV() __asm volatile("sev" ::: "memory")
#define DSB() __asm volatile("dsb" ::: "memory")
#define ISB() __asm volatile("isb" ::: "memory")
#define NOP() __asm volatile("nop")

static inline void irq_disable(void) { __asm volatile("cpsid i" ::: "memory"); }
static inline void irq_enable(void) { __asm volatile("cpsie i" ::: "memory"); }

#define READ_SPECIAL(name)                                                                                              \
    ({                                                                                                                  \
        uint32_t value_;                                                                                                \
        __asm volatile("mrs %0, " name : "=r"(value_)::"memory");                                                       \
        value_;                                                                                                         \
    })

// The ISB makes the next instruction already see the new value (DDI 0403, B5.2.3).
#define WRITE_SPECIAL(name, value) __asm volatile("msr " name ", %0\n isb" ::"r"(value) : "memory")
