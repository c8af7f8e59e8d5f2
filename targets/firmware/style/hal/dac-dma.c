// SPDX-License-Identifier: GPL-2.0-or-later
//
// An application for an STM32F103xE on top of the abstraction layer, as vendors' examples play a wave: TIM6 triggers the DAC
// 32 000 times a second, and DMA2 channel 3 brings the next of 32 words of a sine of 1 kHz for PA4, in circles. UART4 (PC10,
// PC11), 115200 8N1: a banner, then what comes in goes back with its case changed. "wave N" says how often 100 ms went by.

#include "clock.h"
#include "f103e/handlers.h"
#include "f103e/registers.h"
#include "hal.h"
#include "text.h"

#define SAMPLES 32u
#define RATE_HZ 32000u
#define PERIOD_TICKS 100u
#define TIMEOUT_MS 100u

static hal_uart_t uart = {.instance = UART4, .baud = 115200};
static uint8_t received;
static volatile bool has_received;
static volatile uint32_t rounds; // of the wave

// 2048 + 2000 sin(2 pi n / 32)
static const uint16_t sine[SAMPLES] = {
    2048, 2438, 2813, 3159, 3462, 3711, 3896, 4010, 4048, 4010, 3896, 3711, 3462, 3159, 2813, 2438,
    2048, 1658, 1283, 937,  634,  385,  200,  86,   48,   86,   200,  385,  634,  937,  1283, 1658,
};

void SysTick_Handler(void) { hal_inc_tick(); }

void UART4_IRQHandler(void) { hal_uart_irq_handler(&uart); }

void DMA2_Channel3_IRQHandler(void)
{
    DMA2->IFCR = DMA_GIF(3);
    ++rounds;
}

void hal_uart_msp_init(hal_uart_t *handle)
{
    (void)handle;
    RCC->APB1ENR |= RCC_APB1_UART4;
    hal_gpio_init(GPIOC, 1u << 10, PIN_ALTERNATE, false);
    hal_gpio_init(GPIOC, 1u << 11, PIN_FLOATING, false);
    NVIC->ISER[UART4_IRQ / 32] = 1u << UART4_IRQ % 32;
}

void hal_uart_rx_complete_callback(hal_uart_t *handle)
{
    (void)handle;
    has_received = true;
}

static void must(hal_status_t status)
{
    if (status == HAL_OK)
        return;
    irq_disable();
    for (;;) {
    }
}

static void start_wave(void)
{
    RCC->AHBENR |= RCC_AHB_DMA2;
    RCC->APB1ENR |= RCC_APB1_DAC | RCC_APB1_TIM6;
    hal_gpio_init(GPIOA, 1u << 4, PIN_ANALOG, false);

    volatile dma_channel_t *dma = DMA2_CHANNEL(3);
    dma->CPAR = (uint32_t)(uintptr_t)&DAC->DHR12R1;
    dma->CMAR = (uint32_t)(uintptr_t)sine;
    dma->CNDTR = SAMPLES;
    dma->CCR = DMA_CCR_FROM_MEMORY | DMA_CCR_MINC | DMA_CCR_CIRC | DMA_CCR_TCIE | 1u << DMA_CCR_PSIZE_SHIFT |
               1u << DMA_CCR_MSIZE_SHIFT | 2u << DMA_CCR_PL_SHIFT;
    NVIC->ISER[(DMA2_CHANNEL1_IRQ + 2) / 32] = 1u << (DMA2_CHANNEL1_IRQ + 2) % 32;
    dma->CCR |= DMA_CCR_EN;

    DAC->CR = DAC_CR_TEN | DAC_TIM6 << DAC_CR_TSEL_SHIFT | DAC_CR_DMAEN;
    DAC->CR |= DAC_CR_EN;

    TIM6->ARR = 2 * clock_pclk1_hz() / RATE_HZ - 1;
    TIM6->CR2 = TIM_TRGO_UPDATE << TIM_CR2_MMS_SHIFT;
    TIM6->CR1 = TIM_CR1_CEN;
}

static void say(struct line *line)
{
    line_text(line, "\r\n");
    must(hal_uart_transmit(&uart, (const uint8_t *)line->text, line->length, TIMEOUT_MS));
}

static void echo(void)
{
    has_received = false;
    uint8_t byte = received;
    if ((byte | 0x20) >= 'a' && (byte | 0x20) <= 'z')
        byte ^= 0x20;
    must(hal_uart_receive_it(&uart, &received, 1));
    must(hal_uart_transmit(&uart, &byte, 1, TIMEOUT_MS));
}

int main(void)
{
    static const hal_clock_config_t clock = {
        .hse_on = true, .pll_factor = 9, .apb1_divider = APB_DIV2, .flash_wait_states = 2};
    must(hal_init());
    must(hal_clock_config(&clock));
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOA | RCC_APB2_GPIOC;
    must(hal_uart_init(&uart));
    start_wave();
    struct line banner = EMPTY_LINE;
    line_text(&banner, "style-dac-dma at ");
    line_decimal(&banner, RATE_HZ);
    line_text(&banner, " samples/s");
    say(&banner);
    must(hal_uart_receive_it(&uart, &received, 1));

    for (uint32_t next = hal_get_tick() + PERIOD_TICKS;;) {
        if (has_received)
            echo();
        if ((int32_t)(hal_get_tick() - next) < 0)
            continue;
        next += PERIOD_TICKS;
        struct line line = EMPTY_LINE;
        line_text(&line, "wave ");
        line_decimal(&line, rounds);
        say(&line);
    }
}
