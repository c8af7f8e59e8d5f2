// SPDX-License-Identifier: GPL-2.0-or-later
//
// The interrupts that the rover uses, by their numbers (RM0410, table 46).

#pragma once

#include "chip/core.h"

enum irq {
    DMA1_STREAM3_IRQ = 14,
    EXTI9_5_IRQ = 23,
    I2C1_EV_IRQ = 31,
    I2C1_ER_IRQ = 32,
    USART3_IRQ = 39,
    EXTI15_10_IRQ = 40,
    IRQ_COUNT = 110,
};

void DMA1_Stream3_IRQHandler(void);
void EXTI9_5_IRQHandler(void);
void I2C1_EV_IRQHandler(void);
void I2C1_ER_IRQHandler(void);
void USART3_IRQHandler(void);
void EXTI15_10_IRQHandler(void);
void SysTick_Handler(void);

// 0 is the most urgent of 16 levels: this chip implements the upper four bits (RM0410, 10.1).
static inline void irq_enable_line(enum irq irq, unsigned level)
{
    NVIC->IPR[irq] = (uint8_t)(level << 4);
    NVIC->ISER[irq / 32] = 1u << irq % 32;
}
