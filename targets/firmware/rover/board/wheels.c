// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/board/wheels.h"

#include "rover/board/time.h"
#include "rover/chip/exti.h"
#include "rover/chip/gpio.h"
#include "rover/chip/irq.h"
#include "rover/chip/rcc.h"

#define LEVEL 0 // before all others: the time is taken in the handler

static const struct {
    char port;
    uint8_t pin;
} PINS[WHEELS] = {{'E', 7}, {'E', 8}, {'G', 9}, {'G', 14}};

static void handle(void)
{
    uint32_t now_us = time_us(), pending = EXTI->PR;
    for (unsigned wheel = 0; wheel < WHEELS; ++wheel) {
        uint32_t line = 1u << PINS[wheel].pin;
        if (pending & line) {
            EXTI->PR = line;
            wheels_edge(wheel, now_us);
        }
    }
}

void EXTI9_5_IRQHandler(void) { handle(); }
void EXTI15_10_IRQHandler(void) { handle(); }

void wheels_start(void)
{
    RCC->AHB1ENR |= RCC_AHB1_GPIO('E') | RCC_AHB1_GPIO('G');
    RCC->APB2ENR |= RCC_APB2_SYSCFG;
    for (unsigned wheel = 0; wheel < WHEELS; ++wheel) {
        uint32_t line = 1u << PINS[wheel].pin;
        pin_pull_up(GPIO(PINS[wheel].port), PINS[wheel].pin); // a tachometer that is not connected is silent
        pin_mode(GPIO(PINS[wheel].port), PINS[wheel].pin, PIN_INPUT);
        exti_port(PINS[wheel].pin, PINS[wheel].port);
        EXTI->FTSR |= line;
        EXTI->PR = line;
        EXTI->IMR |= line;
    }
    irq_enable_line(EXTI9_5_IRQ, LEVEL);
    irq_enable_line(EXTI15_10_IRQ, LEVEL);
}
