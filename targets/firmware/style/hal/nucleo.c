// SPDX-License-Identifier: GPL-2.0-or-later
//
// An application for the NUCLEO-F103RB on top of the abstraction layer, as a code generator makes it: OSC_IN is driven by the
// debugger's clock of 8 MHz, so HSEBYP is set before HSEON, and the PLL makes 72 MHz of it. USART2 (PA2, PA3: the virtual COM
// port), 115200 8N1: a banner, then what comes in goes back; "button N" when B1 is pushed. LD2 toggles each 50 ms. If a clock
// does not come in time, LD2 stays dark and nothing is said.

#include "clock.h"
#include "hal.h"
#include "handlers.h"
#include "pin.h"
#include "text.h"

#define B1 13u
#define LD2 5u
#define PERIOD_TICKS 50u
#define TIMEOUT_MS 100u

static hal_uart_t uart = {.instance = USART2, .baud = 115200};

void SysTick_Handler(void) { hal_inc_tick(); }

void hal_uart_msp_init(hal_uart_t *handle)
{
    (void)handle;
    RCC->APB1ENR |= RCC_APB1_USART2;
    hal_gpio_init(GPIOA, 1u << 2, PIN_ALTERNATE, false);
    hal_gpio_init(GPIOA, 1u << 3, PIN_FLOATING, false);
}

static void must(hal_status_t status)
{
    if (status == HAL_OK)
        return;
    irq_disable();
    for (;;) {
    }
}

static void start_clock(void)
{
    static const hal_clock_config_t clock = {.hse_on = true, .pll_factor = 9, .apb1_divider = APB_DIV2, .flash_wait_states = 2};
    RCC->CR &= ~RCC_CR_HSEON;
    RCC->CR |= RCC_CR_HSEBYP;
    must(hal_clock_config(&clock));
}

static void say(struct line *line)
{
    line_text(line, "\r\n");
    must(hal_uart_transmit(&uart, (const uint8_t *)line->text, line->length, TIMEOUT_MS));
}

int main(void)
{
    must(hal_init());
    start_clock();
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOA | RCC_APB2_GPIOC;
    hal_gpio_init(GPIOA, 1u << LD2, PIN_OUTPUT, false);
    hal_gpio_init(GPIOC, 1u << B1, PIN_FLOATING, false);
    must(hal_uart_init(&uart));
    struct line banner = EMPTY_LINE;
    line_text(&banner, "style-hse-bypass at ");
    line_decimal(&banner, clock_hclk_hz());
    line_text(&banner, " Hz");
    say(&banner);

    bool pushed = false;
    uint32_t pushes = 0;
    for (uint32_t next = hal_get_tick() + PERIOD_TICKS;;) {
        uint8_t byte;
        if (hal_uart_receive(&uart, &byte, 1, 2) == HAL_OK)
            must(hal_uart_transmit(&uart, &byte, 1, TIMEOUT_MS));
        if (pin_read(GPIOC, B1) == pushed) { // low while it is pushed
            pushed = !pushed;
            if (pushed) {
                struct line line = EMPTY_LINE;
                line_text(&line, "button ");
                line_decimal(&line, ++pushes);
                say(&line);
            }
        }
        if ((int32_t)(hal_get_tick() - next) < 0)
            continue;
        next += PERIOD_TICKS;
        hal_gpio_toggle(GPIOA, 1u << LD2);
    }
}
