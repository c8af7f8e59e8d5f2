// SPDX-License-Identifier: GPL-2.0-or-later
//
// From reset to main: the vector table (RM0433, section 19.1.2), the floating-point unit, and memory as C expects to find it.

#include "chip/core.h"
#include "chip/core_m7.h"
#include "vehicle_interface/chip/irq.h"

extern uint32_t ld_main_stack_top[], ld_data_load[], ld_data_start[], ld_data_end[], ld_bss_start[], ld_bss_end[];

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

// Nobody would drive here any more: the watchdog ends that.
static void unhandled_exception(void)
{
    for (;;) {
    }
}

#define NONE unhandled_exception

// The stack pointer stands in the place of exception number 0.
__attribute__((section(".vectors"), used)) const struct {
    uint32_t *stack;
    void (*exception[15])(void);
    void (*irq[IRQ_COUNT])(void);
} vector_table = {
    .stack = ld_main_stack_top,
    .exception = {Reset_Handler, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, PendSV_Handler,
                  SysTick_Handler},
    .irq = {[0 ... DMA1_STREAM1_IRQ - 1] = NONE,
            [DMA1_STREAM1_IRQ] = DMA1_Stream1_IRQHandler,
            [DMA1_STREAM1_IRQ + 1 ... USART2_IRQ - 1] = NONE,
            [USART2_IRQ] = USART2_IRQHandler,
            [USART3_IRQ] = USART3_IRQHandler,
            [EXTI15_10_IRQ] = EXTI15_10_IRQHandler,
            [EXTI15_10_IRQ + 1 ... DMA2_STREAM1_IRQ - 1] = NONE,
            [DMA2_STREAM1_IRQ] = DMA2_Stream1_IRQHandler,
            [DMA2_STREAM2_IRQ] = DMA2_Stream2_IRQHandler,
            [DMA2_STREAM2_IRQ + 1 ... IRQ_COUNT - 1] = NONE},
};
