// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: a thin layer over the registers, and a program that sleeps. TIM4's update wakes WFE as an event, without
// an interrupt handler (SEVONPEND), and the LED toggles each 100 ms; ten times, then the chip goes to Stop mode until PA0
// rises (pulled down; EXTI0, interrupt). Stop mode ends on HSI: the clock has to be set up again (RM0008, 5.3.4).
// USART1 (PA9, 115200 8N1) prints "stop" before and "woken N" after.

#include "chip/stm32f103.h"
#include "clock.h"
#include "handlers.h"
#include "pin.h"
#include "text.h"

#define BAUD 115200u
#define BUTTON 0
#define LED 13

// --- The layer: one inline function for each thing one can do to a register

static inline void ll_tim_set_prescaler(volatile tim_t *tim, uint32_t value) { tim->PSC = value; }
static inline void ll_tim_set_auto_reload(volatile tim_t *tim, uint32_t value) { tim->ARR = value; }
static inline void ll_tim_generate_update(volatile tim_t *tim) { tim->EGR = TIM_EGR_UG; }
static inline void ll_tim_clear_update(volatile tim_t *tim) { tim->SR = ~TIM_UIF; }
static inline void ll_tim_enable_update_interrupt(volatile tim_t *tim) { tim->DIER |= TIM_UIF; }
static inline void ll_tim_enable_counter(volatile tim_t *tim) { tim->CR1 |= TIM_CR1_CEN; }
static inline void ll_tim_disable_counter(volatile tim_t *tim) { tim->CR1 &= ~TIM_CR1_CEN; }
static inline void ll_exti_enable_interrupt(uint32_t line) { EXTI->IMR |= line; }
static inline void ll_exti_enable_rising(uint32_t line) { EXTI->RTSR |= line; }
static inline void ll_exti_clear(uint32_t line) { EXTI->PR = line; }
static inline void ll_pwr_set_stop_low_power_regulator(void) { PWR->CR = (PWR->CR & ~PWR_CR_PDDS) | PWR_CR_LPDS; }
static inline void ll_lpm_enable_deep_sleep(void) { SCB->SCR |= SCR_SLEEPDEEP; }
static inline void ll_lpm_enable_sleep(void) { SCB->SCR &= ~SCR_SLEEPDEEP; }
static inline void ll_lpm_enable_event_on_pend(void) { SCB->SCR |= SCR_SEVONPEND; }

// --- The program

static volatile uint32_t wakes;

void EXTI0_IRQHandler(void)
{
    ll_exti_clear(1u << BUTTON);
    ++wakes;
}

static void print(const char *text)
{
    for (; *text; ++text) {
        while (!(USART1->SR & USART_SR_TXE)) {
        }
        USART1->DR = (uint8_t)*text;
    }
    while (!(USART1->SR & USART_SR_TC)) {
    }
}

// Sleeps until TIM4 pends its interrupt, which nobody takes: it is disabled in the NVIC, and an event all the same.
static void sleep_until_update(void)
{
    while (!irq_is_pending(TIM4_IRQ))
        WFE();
    ll_tim_clear_update(TIM4);
    irq_unpend(TIM4_IRQ);
}

static void stop_until_button(void)
{
    uint32_t before = wakes;
    print("stop\r\n");
    ll_tim_disable_counter(TIM4);
    ll_pwr_set_stop_low_power_regulator();
    ll_lpm_enable_deep_sleep();
    while (wakes == before)
        WFI();
    ll_lpm_enable_sleep();
    clock_72mhz();
    ll_tim_enable_counter(TIM4);
    struct line line = EMPTY_LINE;
    line_text(&line, "woken ");
    line_decimal(&line, wakes);
    line_text(&line, "\r\n");
    print(line.text);
}

static void set_up(void)
{
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOA | RCC_APB2_GPIOC | RCC_APB2_USART1;
    RCC->APB1ENR |= RCC_APB1_TIM4 | RCC_APB1_PWR;
    pin_write(GPIOC, LED, true);
    pin_mode(GPIOC, LED, PIN_OUTPUT);
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    pin_pull(GPIOA, BUTTON, false);
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE;
    ll_exti_enable_rising(1u << BUTTON);
    ll_exti_enable_interrupt(1u << BUTTON);
    irq_line_enable(EXTI0_IRQ);
    ll_tim_set_prescaler(TIM4, 7200 - 1);
    ll_tim_set_auto_reload(TIM4, 1000 - 1);
    ll_tim_generate_update(TIM4);
    ll_tim_clear_update(TIM4);
    ll_tim_enable_update_interrupt(TIM4);
    irq_unpend(TIM4_IRQ);
    ll_lpm_enable_event_on_pend();
    ll_tim_enable_counter(TIM4);
}

int main(void)
{
    clock_72mhz();
    set_up();
    for (;;) {
        for (int i = 0; i < 10; ++i) {
            sleep_until_update();
            pin_toggle(GPIOC, LED);
        }
        stop_until_button();
    }
}
