// SPDX-License-Identifier: GPL-2.0-or-later
//
// From reset to main: the vector table (RM0410, table 46), the floating-point unit, and memory as C expects to find it.

#include "chip/core.h"
#include "chip/core_m7.h"
#include "rover/chip/irq.h"

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

// The motors would keep the last throttle here for ever: the watchdog ends that.
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
    .stack = ld_stack_top,
    .exception = {Reset_Handler, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE,
                  SysTick_Handler},
    .irq = {[0 ... DMA1_STREAM3_IRQ - 1] = NONE,
            [DMA1_STREAM3_IRQ] = DMA1_Stream3_IRQHandler,
            [DMA1_STREAM3_IRQ + 1 ... EXTI9_5_IRQ - 1] = NONE,
            [EXTI9_5_IRQ] = EXTI9_5_IRQHandler,
            [EXTI9_5_IRQ + 1 ... I2C1_EV_IRQ - 1] = NONE,
            [I2C1_EV_IRQ] = I2C1_EV_IRQHandler,
            [I2C1_ER_IRQ] = I2C1_ER_IRQHandler,
            [I2C1_ER_IRQ + 1 ... USART3_IRQ - 1] = NONE,
            [USART3_IRQ] = USART3_IRQHandler,
            [EXTI15_10_IRQ] = EXTI15_10_IRQHandler,
            [EXTI15_10_IRQ + 1 ... IRQ_COUNT - 1] = NONE},
};
