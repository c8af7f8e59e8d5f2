// SPDX-License-Identifier: GPL-2.0-or-later
//
// The interrupts that only high-density devices have, in the order of their numbers, 43 to 59 (RM0008, table 63).

#pragma once

#include "common/handlers.h"

#define HIGH_DENSITY_HANDLERS(X)                                                                                        \
    X(TIM8_BRK_IRQHandler)                                                                                              \
    X(TIM8_UP_IRQHandler)                                                                                               \
    X(TIM8_TRG_COM_IRQHandler)                                                                                          \
    X(TIM8_CC_IRQHandler)                                                                                               \
    X(ADC3_IRQHandler)                                                                                                  \
    X(FSMC_IRQHandler)                                                                                                  \
    X(SDIO_IRQHandler)                                                                                                  \
    X(TIM5_IRQHandler)                                                                                                  \
    X(SPI3_IRQHandler)                                                                                                  \
    X(UART4_IRQHandler)                                                                                                 \
    X(UART5_IRQHandler)                                                                                                 \
    X(TIM6_IRQHandler)                                                                                                  \
    X(TIM7_IRQHandler)                                                                                                  \
    X(DMA2_Channel1_IRQHandler)                                                                                         \
    X(DMA2_Channel2_IRQHandler)                                                                                         \
    X(DMA2_Channel3_IRQHandler)                                                                                         \
    X(DMA2_Channel4_5_IRQHandler)

HIGH_DENSITY_HANDLERS(DECLARE_IRQ_HANDLER_)
