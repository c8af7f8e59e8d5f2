// SPDX-License-Identifier: GPL-2.0-or-later
//
// Everything of the STM32F103x8, written from the reference manual (RM0008) for this firmware.

#pragma once

#include "chip/core.h"
#include "chip/cpu.h"
#include "chip/crc.h"
#include "chip/dma.h"
#include "chip/exti.h"
#include "chip/flash.h"
#include "chip/gpio.h"
#include "chip/irq.h"
#include "chip/power.h"
#include "chip/rcc.h"
#include "chip/tim.h"
#include "chip/usart.h"
#include "chip/watchdog.h"

#define DBGMCU_IDCODE (*(volatile uint32_t *)0xE0042000u)
#define DBGMCU_CR (*(volatile uint32_t *)0xE0042004u)

#define RAM_BASE 0x20000000u
#define FLASH_BASE 0x08000000u

// The word in the alias region that is one bit of a peripheral register (DDI 0403, B3.1; RM0008, 3.3.1).
static inline volatile uint32_t *bit_of(volatile void *address, unsigned bit)
{
    uint32_t at = (uint32_t)(uintptr_t)address;
    return (volatile uint32_t *)((at & 0xF0000000u) + 0x02000000u + (at & 0x000FFFFFu) * 32u + bit * 4u);
}
