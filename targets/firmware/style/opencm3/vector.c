// SPDX-License-Identifier: GPL-2.0-or-later
//
// Vectors and start. What no program defines waits for ever (blocking_handler) or does nothing (null_handler).

#include <stdint.h>

#include "opencm3.h"

extern uint32_t ld_stack_top[], ld_data_load[], ld_data_start[], ld_data_end[], ld_bss_start[], ld_bss_end[];

int main(void);
void reset_handler(void);
void blocking_handler(void);
void null_handler(void);

void blocking_handler(void)
{
    for (;;) {
    }
}

void null_handler(void) {}

void reset_handler(void)
{
    volatile uint32_t *from = ld_data_load, *to = ld_data_start;
    while (to < ld_data_end)
        *to++ = *from++;
    to = ld_bss_start;
    while (to < ld_bss_end)
        *to++ = 0;
    main();
    blocking_handler();
}

void Reset_Handler(void) __attribute__((alias("reset_handler"))); // as the linker script calls it

#define BLOCKING(name) void name(void) __attribute__((weak, alias("blocking_handler")));
#define NULL_HANDLER(name) void name(void) __attribute__((weak, alias("null_handler")));

BLOCKING(hard_fault_handler)
BLOCKING(mem_manage_handler)
BLOCKING(bus_fault_handler)
BLOCKING(usage_fault_handler)
NULL_HANDLER(nmi_handler)
NULL_HANDLER(sv_call_handler)
NULL_HANDLER(debug_monitor_handler)
NULL_HANDLER(pend_sv_handler)
NULL_HANDLER(sys_tick_handler)

// By the numbers of RM0008, table 63.
#define IRQS(X)                                                                                                         \
    X(wwdg_isr)                                                                                                         \
    X(pvd_isr)                                                                                                          \
    X(tamper_isr)                                                                                                       \
    X(rtc_isr)                                                                                                          \
    X(flash_isr)                                                                                                        \
    X(rcc_isr)                                                                                                          \
    X(exti0_isr)                                                                                                        \
    X(exti1_isr)                                                                                                        \
    X(exti2_isr)                                                                                                        \
    X(exti3_isr)                                                                                                        \
    X(exti4_isr)                                                                                                        \
    X(dma1_channel1_isr)                                                                                                \
    X(dma1_channel2_isr)                                                                                                \
    X(dma1_channel3_isr)                                                                                                \
    X(dma1_channel4_isr)                                                                                                \
    X(dma1_channel5_isr)                                                                                                \
    X(dma1_channel6_isr)                                                                                                \
    X(dma1_channel7_isr)                                                                                                \
    X(adc1_2_isr)                                                                                                       \
    X(usb_hp_can_tx_isr)                                                                                                \
    X(usb_lp_can_rx0_isr)                                                                                               \
    X(can_rx1_isr)                                                                                                      \
    X(can_sce_isr)                                                                                                      \
    X(exti9_5_isr)                                                                                                      \
    X(tim1_brk_isr)                                                                                                     \
    X(tim1_up_isr)                                                                                                      \
    X(tim1_trg_com_isr)                                                                                                 \
    X(tim1_cc_isr)                                                                                                      \
    X(tim2_isr)                                                                                                         \
    X(tim3_isr)                                                                                                         \
    X(tim4_isr)                                                                                                         \
    X(i2c1_ev_isr)                                                                                                      \
    X(i2c1_er_isr)                                                                                                      \
    X(i2c2_ev_isr)                                                                                                      \
    X(i2c2_er_isr)                                                                                                      \
    X(spi1_isr)                                                                                                         \
    X(spi2_isr)                                                                                                         \
    X(usart1_isr)                                                                                                       \
    X(usart2_isr)                                                                                                       \
    X(usart3_isr)                                                                                                       \
    X(exti15_10_isr)                                                                                                    \
    X(rtc_alarm_isr)                                                                                                    \
    X(usb_wakeup_isr)

#define VECTOR(name) name,

IRQS(BLOCKING)

__attribute__((section(".vectors"), used)) const struct {
    uint32_t *initial_sp_value;
    void (*reset)(void), (*nmi)(void), (*hard_fault)(void), (*memory_manage_fault)(void), (*bus_fault)(void);
    void (*usage_fault)(void), (*reserved0[4])(void), (*sv_call)(void), (*debug_monitor)(void), (*reserved1)(void);
    void (*pend_sv)(void), (*systick)(void), (*irq[IRQ_COUNT])(void);
} vector_table = {
    .initial_sp_value = ld_stack_top,
    .reset = reset_handler,
    .nmi = nmi_handler,
    .hard_fault = hard_fault_handler,
    .memory_manage_fault = mem_manage_handler,
    .bus_fault = bus_fault_handler,
    .usage_fault = usage_fault_handler,
    .sv_call = sv_call_handler,
    .debug_monitor = debug_monitor_handler,
    .pend_sv = pend_sv_handler,
    .systick = sys_tick_handler,
    .irq = {IRQS(VECTOR)},
};
