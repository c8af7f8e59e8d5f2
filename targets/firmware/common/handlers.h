// SPDX-License-Identifier: GPL-2.0-or-later
//
// The names of all exception handlers. An image that handles an exception defines the function of that name; declared
// here, a misspelt one does not pass unnoticed.

#pragma once

// System exceptions by number (DDI 0403, table B1-4); those left out are reserved.
#define SYSTEM_HANDLERS(X)                                                                                              \
    X(2, NMI_Handler)                                                                                                   \
    X(3, HardFault_Handler)                                                                                             \
    X(4, MemManage_Handler)                                                                                             \
    X(5, BusFault_Handler)                                                                                              \
    X(6, UsageFault_Handler)                                                                                            \
    X(11, SVC_Handler)                                                                                                  \
    X(12, DebugMon_Handler)                                                                                             \
    X(14, PendSV_Handler)                                                                                               \
    X(15, SysTick_Handler)

// Interrupts in the order of their numbers, 0 to 42 (RM0008, table 63).
#define IRQ_HANDLERS(X)                                                                                                 \
    X(WWDG_IRQHandler)                                                                                                  \
    X(PVD_IRQHandler)                                                                                                   \
    X(TAMPER_IRQHandler)                                                                                                \
    X(RTC_IRQHandler)                                                                                                   \
    X(FLASH_IRQHandler)                                                                                                 \
    X(RCC_IRQHandler)                                                                                                   \
    X(EXTI0_IRQHandler)                                                                                                 \
    X(EXTI1_IRQHandler)                                                                                                 \
    X(EXTI2_IRQHandler)                                                                                                 \
    X(EXTI3_IRQHandler)                                                                                                 \
    X(EXTI4_IRQHandler)                                                                                                 \
    X(DMA1_Channel1_IRQHandler)                                                                                         \
    X(DMA1_Channel2_IRQHandler)                                                                                         \
    X(DMA1_Channel3_IRQHandler)                                                                                         \
    X(DMA1_Channel4_IRQHandler)                                                                                         \
    X(DMA1_Channel5_IRQHandler)                                                                                         \
    X(DMA1_Channel6_IRQHandler)                                                                                         \
    X(DMA1_Channel7_IRQHandler)                                                                                         \
    X(ADC1_2_IRQHandler)                                                                                                \
    X(USB_HP_CAN_TX_IRQHandler)                                                                                         \
    X(USB_LP_CAN_RX0_IRQHandler)                                                                                        \
    X(CAN_RX1_IRQHandler)                                                                                               \
    X(CAN_SCE_IRQHandler)                                                                                               \
    X(EXTI9_5_IRQHandler)                                                                                               \
    X(TIM1_BRK_IRQHandler)                                                                                              \
    X(TIM1_UP_IRQHandler)                                                                                               \
    X(TIM1_TRG_COM_IRQHandler)                                                                                          \
    X(TIM1_CC_IRQHandler)                                                                                               \
    X(TIM2_IRQHandler)                                                                                                  \
    X(TIM3_IRQHandler)                                                                                                  \
    X(TIM4_IRQHandler)                                                                                                  \
    X(I2C1_EV_IRQHandler)                                                                                               \
    X(I2C1_ER_IRQHandler)                                                                                               \
    X(I2C2_EV_IRQHandler)                                                                                               \
    X(I2C2_ER_IRQHandler)                                                                                               \
    X(SPI1_IRQHandler)                                                                                                  \
    X(SPI2_IRQHandler)                                                                                                  \
    X(USART1_IRQHandler)                                                                                                \
    X(USART2_IRQHandler)                                                                                                \
    X(USART3_IRQHandler)                                                                                                \
    X(EXTI15_10_IRQHandler)                                                                                             \
    X(RTCAlarm_IRQHandler)                                                                                              \
    X(USBWakeup_IRQHandler)

#define DECLARE_SYSTEM_HANDLER_(number, name) void name(void);
#define DECLARE_IRQ_HANDLER_(name) void name(void);

SYSTEM_HANDLERS(DECLARE_SYSTEM_HANDLER_)
IRQ_HANDLERS(DECLARE_IRQ_HANDLER_)

void Reset_Handler(void);
