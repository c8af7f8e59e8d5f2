// SPDX-License-Identifier: GPL-2.0-or-later
//
// The exceptions that these images handle, by number; an image that handles one defines its function.

#pragma once

#define H753_HANDLERS(X)                                                                                                \
    X(3, HardFault_Handler)                                                                                             \
    X(15, SysTick_Handler)                                                                                              \
    X(16 + 4, FLASH_IRQHandler)                                                                                         \
    X(16 + 5, RCC_IRQHandler)                                                                                           \
    X(16 + 38, USART2_IRQHandler)                                                                                       \
    X(16 + 39, USART3_IRQHandler)                                                                                       \
    X(16 + 40, EXTI15_10_IRQHandler)                                                                                    \
    X(16 + 56, DMA2_Stream0_IRQHandler)                                                                                 \
    X(16 + 125, HSEM_IRQHandler)                                                                                        \
    X(16 + 127, ADC3_IRQHandler)

#define DECLARE_HANDLER(number, name) void name(void);
H753_HANDLERS(DECLARE_HANDLER)
