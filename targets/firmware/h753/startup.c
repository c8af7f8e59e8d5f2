// SPDX-License-Identifier: GPL-2.0-or-later
//
// From reset to main: the vector table (RM0433, section 19.1.2), the floating-point unit, and memory as C expects to find it.

#include "h753/handlers.h"

#include <stdint.h>

#include "h753/registers.h"

extern uint32_t ld_stack_top[], ld_data_load[], ld_data_start[], ld_data_end[], ld_bss_start[], ld_bss_end[];

int main(void);
void Reset_Handler(void);

void Reset_Handler(void)
{
    CPACR |= CPACR_FPU;
    __asm volatile("dsb\n isb");
    uint32_t *from = ld_data_load;
    for (uint32_t *to = ld_data_start; to < ld_data_end; ++to)
        *to = *from++;
    for (uint32_t *to = ld_bss_start; to < ld_bss_end; ++to)
        *to = 0;
    main();
    for (;;) {
    }
}

static void unhandled_exception(void)
{
    for (;;) {
    }
}

#define DEFAULT_HANDLER(number, name) __attribute__((weak, alias("unhandled_exception"))) void name(void);
H753_HANDLERS(DEFAULT_HANDLER)

#define VECTOR(number, name) [number - 1] = name,
#define VECTORS (16 + IRQ_COUNT)

// All vectors lead to unhandled_exception first, and those of H753_HANDLERS then lead elsewhere.
#pragma GCC diagnostic ignored "-Woverride-init"

// The stack pointer stands in the place of exception number 0.
__attribute__((section(".vectors"), used)) const struct {
    uint32_t *stack;
    void (*handler[VECTORS - 1])(void);
} vector_table = {
    .stack = ld_stack_top,
    .handler = {Reset_Handler, [1 ... VECTORS - 2] = unhandled_exception, H753_HANDLERS(VECTOR)},
};
