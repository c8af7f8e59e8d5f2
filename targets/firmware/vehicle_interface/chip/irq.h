// SPDX-License-Identifier: GPL-2.0-or-later
//
// The interrupts that the vehicle interface uses, by their numbers (RM0433, table 149), and their levels: those of the
// original's CubeMX project.

#pragma once

#include "chip/core.h"

enum irq {
    DMA1_STREAM1_IRQ = 12,
    USART2_IRQ = 38,
    USART3_IRQ = 39,
    EXTI15_10_IRQ = 40,
    DMA2_STREAM1_IRQ = 57,
    DMA2_STREAM2_IRQ = 58,
    IRQ_COUNT = 150,
};

enum irq_level { LEVEL_DMA = 5, LEVEL_USART2 = 5, LEVEL_SWITCH = 7, LEVEL_USART3 = 8, LEVEL_TICK = 14, LEVEL_PENDSV = 15 };

void DMA1_Stream1_IRQHandler(void);
void USART2_IRQHandler(void);
void USART3_IRQHandler(void);
void EXTI15_10_IRQHandler(void);
void DMA2_Stream1_IRQHandler(void);
void DMA2_Stream2_IRQHandler(void);
void PendSV_Handler(void);
void SysTick_Handler(void);

// 0 is the most urgent of 16 levels: this chip implements the upper four bits (RM0433, 19.1).
static inline void irq_enable_line(enum irq irq, enum irq_level level)
{
    NVIC->IPR[irq] = (uint8_t)(level << 4);
    NVIC->ISER[irq / 32] = 1u << irq % 32;
}
