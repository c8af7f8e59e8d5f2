// SPDX-License-Identifier: GPL-2.0-or-later
//
// Interrupt numbers of medium-density devices: position in the vector table (RM0008, table 63) and what one does with them.

#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "chip/core.h"

enum irq {
    WWDG_IRQ = 0,
    PVD_IRQ = 1,
    TAMPER_IRQ = 2,
    RTC_IRQ = 3,
    FLASH_IRQ = 4,
    RCC_IRQ = 5,
    EXTI0_IRQ = 6,
    EXTI1_IRQ = 7,
    EXTI2_IRQ = 8,
    EXTI3_IRQ = 9,
    EXTI4_IRQ = 10,
    DMA1_CHANNEL1_IRQ = 11, // channel n: DMA1_CHANNEL1_IRQ + n - 1
    ADC1_2_IRQ = 18,
    USB_HP_CAN_TX_IRQ = 19,
    USB_LP_CAN_RX0_IRQ = 20,
    CAN_RX1_IRQ = 21,
    CAN_SCE_IRQ = 22,
    EXTI9_5_IRQ = 23,
    TIM1_BRK_IRQ = 24,
    TIM1_UP_IRQ = 25,
    TIM1_TRG_COM_IRQ = 26,
    TIM1_CC_IRQ = 27,
    TIM2_IRQ = 28,
    TIM3_IRQ = 29,
    TIM4_IRQ = 30,
    I2C1_EV_IRQ = 31,
    I2C1_ER_IRQ = 32,
    I2C2_EV_IRQ = 33,
    I2C2_ER_IRQ = 34,
    SPI1_IRQ = 35,
    SPI2_IRQ = 36,
    USART1_IRQ = 37,
    USART2_IRQ = 38,
    USART3_IRQ = 39,
    EXTI15_10_IRQ = 40,
    RTC_ALARM_IRQ = 41,
    USB_WAKEUP_IRQ = 42,
    IRQ_COUNT = 43,
};

#define IRQ_BIT(irq) (1u << ((irq) % 32))

static inline void irq_line_enable(enum irq irq) { NVIC->ISER[irq / 32] = IRQ_BIT(irq); }
static inline void irq_line_disable(enum irq irq) { NVIC->ICER[irq / 32] = IRQ_BIT(irq); }
static inline void irq_pend(enum irq irq) { NVIC->ISPR[irq / 32] = IRQ_BIT(irq); }
static inline void irq_unpend(enum irq irq) { NVIC->ICPR[irq / 32] = IRQ_BIT(irq); }
static inline bool irq_is_pending(enum irq irq) { return (NVIC->ISPR[irq / 32] & IRQ_BIT(irq)) != 0; }
static inline bool irq_is_active(enum irq irq) { return (NVIC->IABR[irq / 32] & IRQ_BIT(irq)) != 0; }

// 0 is the most urgent of 16 levels: this chip implements the upper four bits (RM0008, 10.1.1).
static inline void irq_priority(enum irq irq, unsigned level) { NVIC->IPR[irq] = (uint8_t)(level << 4); }

// Of a system exception, by its number 4 to 15.
static inline void exception_priority(unsigned number, unsigned level) { SCB->SHPR[number - 4] = (uint8_t)(level << 4); }

enum exception {
    EXCEPTION_NMI = 2,
    EXCEPTION_HARDFAULT = 3,
    EXCEPTION_MEMMANAGE = 4,
    EXCEPTION_BUSFAULT = 5,
    EXCEPTION_USAGEFAULT = 6,
    EXCEPTION_SVCALL = 11,
    EXCEPTION_PENDSV = 14,
    EXCEPTION_SYSTICK = 15,
};
