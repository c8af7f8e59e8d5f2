// SPDX-License-Identifier: GPL-2.0-or-later
//
// The application on top of the abstraction layer. USART2 (PA2, PA3), 115200 8N1: a banner, then each 100 ms "tick N", and
// whatever comes in goes back in upper case. The LED toggles with each tick; PA6 carries 1 kHz of PWM, its duty growing by
// 10 % with each tick; PB0 toggles each 5 ms from a timer's callback.

#include "clock.h"
#include "hal.h"
#include "handlers.h"
#include "text.h"

#define LED (1u << 13)
#define PERIOD_TICKS 100u
#define TIMEOUT_MS 100u

static hal_uart_t uart = {.instance = USART2, .baud = 115200};
static hal_tim_t pwm_timer = {.instance = TIM3, .prescaler = 71, .period = 999};  // 1 us, 1 ms
static hal_tim_t base_timer = {.instance = TIM4, .prescaler = 7199, .period = 49}; // 0.1 ms, 5 ms

void SysTick_Handler(void) { hal_inc_tick(); }
void TIM4_IRQHandler(void) { hal_tim_irq_handler(&base_timer); }
void USART2_IRQHandler(void) { hal_uart_irq_handler(&uart); }

void hal_uart_msp_init(hal_uart_t *handle)
{
    (void)handle;
    RCC->APB1ENR |= RCC_APB1_USART2;
    hal_gpio_init(GPIOA, 1u << 2, PIN_ALTERNATE, false);
    hal_gpio_init(GPIOA, 1u << 3, PIN_PULLED, true);
    irq_priority(USART2_IRQ, 5);
    irq_line_enable(USART2_IRQ);
}

void hal_tim_msp_init(hal_tim_t *handle)
{
    if (handle == &pwm_timer) {
        RCC->APB1ENR |= RCC_APB1_TIM3;
        hal_gpio_init(GPIOA, 1u << 6, PIN_ALTERNATE, false);
    } else {
        RCC->APB1ENR |= RCC_APB1_TIM4;
        irq_priority(TIM4_IRQ, 6);
        irq_line_enable(TIM4_IRQ);
    }
}

void hal_tim_period_elapsed_callback(hal_tim_t *handle)
{
    (void)handle;
    hal_gpio_toggle(GPIOB, 1u << 0);
}

static volatile bool line_out_done = true;

void hal_uart_tx_complete_callback(hal_uart_t *handle)
{
    (void)handle;
    line_out_done = true;
}

__attribute__((noreturn)) static void error_handler(void)
{
    irq_disable();
    for (;;) {
    }
}

static void must(hal_status_t status)
{
    if (status != HAL_OK)
        error_handler();
}

static void print_banner(void)
{
    struct line line = EMPTY_LINE;
    line_text(&line, "style-hal at ");
    line_decimal(&line, clock_hclk_hz());
    line_text(&line, " Hz\r\n");
    must(hal_uart_transmit(&uart, (const uint8_t *)line.text, line.length, TIMEOUT_MS));
}

// Sent by interrupt, so that the loop goes on listening meanwhile.
static void print_tick(uint32_t number)
{
    static struct line line;
    if (!line_out_done)
        return;
    line = EMPTY_LINE;
    line_text(&line, "tick ");
    line_decimal(&line, number);
    line_text(&line, "\r\n");
    line_out_done = false;
    must(hal_uart_transmit_it(&uart, (const uint8_t *)line.text, line.length));
}

static void answer(uint8_t byte)
{
    if (byte >= 'a' && byte <= 'z')
        byte -= 'a' - 'A';
    while (hal_uart_transmit(&uart, &byte, 1, TIMEOUT_MS) == HAL_BUSY) {
    }
}

int main(void)
{
    static const hal_clock_config_t clock = {.hse_on = true, .pll_factor = 9, .apb1_divider = APB_DIV2, .flash_wait_states = 2};
    must(hal_init());
    must(hal_clock_config(&clock));
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOA | RCC_APB2_GPIOB | RCC_APB2_GPIOC;
    hal_gpio_write(GPIOC, LED, true);
    hal_gpio_init(GPIOC, LED, PIN_OUTPUT, false);
    hal_gpio_init(GPIOB, 1u << 0, PIN_OUTPUT, false);
    must(hal_uart_init(&uart));
    must(hal_tim_base_init(&pwm_timer));
    must(hal_tim_pwm_start(&pwm_timer, 1, 0));
    must(hal_tim_base_init(&base_timer));
    must(hal_tim_base_start_it(&base_timer));
    print_banner();

    uint32_t next = hal_get_tick() + PERIOD_TICKS;
    for (uint32_t number = 1;;) {
        uint8_t byte;
        if (hal_uart_receive(&uart, &byte, 1, 10) == HAL_OK)
            answer(byte);
        if ((int32_t)(hal_get_tick() - next) < 0)
            continue;
        next += PERIOD_TICKS;
        hal_gpio_toggle(GPIOC, LED);
        pwm_timer.instance->CCR[0] = number % 11 * 100;
        print_tick(number++);
    }
}
