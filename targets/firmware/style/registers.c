// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: bare registers. Addresses copied from the reference manual, the clock as it is after reset (HSI, 8 MHz),
// a busy loop for time. The LED on PC13 is on for half of each second, more or less.

#include "startup.h"

#define RCC_APB2ENR (*(volatile uint32_t *)0x40021018)
#define GPIOC_CRH (*(volatile uint32_t *)0x40011004)
#define GPIOC_ODR (*(volatile uint32_t *)0x4001100C)

#define HALF_SECOND 400000 // turns of the loop below, about ten cycles each

int main(void)
{
    RCC_APB2ENR |= 1 << 4;                           // clock for port C
    GPIOC_CRH = (GPIOC_CRH & ~0x00F00000) | 0x00200000; // PC13: output, push-pull, 2 MHz
    for (;;) {
        GPIOC_ODR ^= 1 << 13;
        for (volatile int i = 0; i < HALF_SECOND; i++) {
        }
    }
}
