// SPDX-License-Identifier: GPL-2.0-or-later
//
// A tiny boot loader in the first 8 KB. If PB9 is pulled to ground it stays and blinks fast; else, or when there is an
// application at 0x08002000, it hands over: vector table, stack pointer, jump, everything else as after a reset.

#include "chip/stm32f103.h"
#include "pin.h"
#include "startup.h"

#define APPLICATION 0x08002000u
#define STAY 9
#define LED 13

// Only a stack that lies in RAM makes an application; erased flash memory reads 0xFFFFFFFF.
static bool there_is_an_application(void)
{
    uint32_t stack = ((const uint32_t *)APPLICATION)[0];
    return stack > RAM_BASE && stack <= RAM_BASE + 20 * 1024;
}

static bool asked_to_stay(void)
{
    RCC->APB2ENR |= RCC_APB2_GPIOB;
    pin_pull(GPIOB, STAY, true);
    for (volatile int i = 0; i < 100; i++) {
    }
    bool stay = !pin_read(GPIOB, STAY);
    pin_mode(GPIOB, STAY, PIN_FLOATING);
    RCC->APB2ENR = 0;
    return stay;
}

__attribute__((noreturn)) static void hand_over(void)
{
    const uint32_t *vectors = (const uint32_t *)APPLICATION;
    SCB->VTOR = APPLICATION;
    __asm volatile("msr msp, %0\n bx %1" ::"r"(vectors[0]), "r"(vectors[1]));
    __builtin_unreachable();
}

int main(void)
{
    if (!asked_to_stay() && there_is_an_application())
        hand_over();
    RCC->APB2ENR |= RCC_APB2_GPIOC;
    pin_mode(GPIOC, LED, PIN_OUTPUT);
    for (;;) {
        pin_toggle(GPIOC, LED);
        for (volatile int i = 0; i < 40000; i++) {
        }
    }
}
