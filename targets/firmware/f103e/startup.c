// SPDX-License-Identifier: GPL-2.0-or-later
//
// From reset to main: the vector table of a high-density device (RM0008, table 63), and memory as C expects to find it.

#include <stdint.h>

#include "f103e/handlers.h"

#define VECTORS (16 + 60)

extern uint32_t ld_stack_top[], ld_data_load[], ld_data_start[], ld_data_end[], ld_bss_start[], ld_bss_end[];

int main(void);

void Reset_Handler(void)
{
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

#define DEFAULT_HANDLER(name) __attribute__((weak, alias("unhandled_exception"))) void name(void);
#define DEFAULT_SYSTEM_HANDLER(number, name) DEFAULT_HANDLER(name)

SYSTEM_HANDLERS(DEFAULT_SYSTEM_HANDLER)
IRQ_HANDLERS(DEFAULT_HANDLER)
HIGH_DENSITY_HANDLERS(DEFAULT_HANDLER)

#define SYSTEM_VECTOR(number, name) [number - 1] = name,
#define IRQ_VECTOR(name) name,

// The stack pointer stands in the place of exception number 0.
__attribute__((section(".vectors"), used)) const struct {
    uint32_t *stack;
    void (*handler[VECTORS - 1])(void);
} vector_table = {
    .stack = ld_stack_top,
    .handler = {Reset_Handler, SYSTEM_HANDLERS(SYSTEM_VECTOR) IRQ_HANDLERS(IRQ_VECTOR) HIGH_DENSITY_HANDLERS(IRQ_VECTOR)},
};
