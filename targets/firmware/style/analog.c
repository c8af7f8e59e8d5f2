// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: sketches and drivers that read voltages. First as a sketch does, one call for each reading, with the
// converter switched on, calibrated, started, polled and switched off again: PA0, the sensor and the reference, by which the
// supply is known. Then as a driver does: TIM3 triggers a scan of PA0 and PA1 each 100 us, DMA puts both into a circle of
// 16 pairs, and half and full interrupts add up what came; each 10 ms a line says the means. What leaves 1 V to 2.5 V at PA1
// trips the watchdog, which lights PC13. USART1 (PA9), 115200 8N1, polled.

#include "chip/adc.h"
#include "chip/stm32f103.h"
#include "clock.h"
#include "cycles.h"
#include "handlers.h"
#include "pin.h"
#include "text.h"

#define BAUD 115200u
#define LED 13
#define PAIRS 16u
#define FULL_MV 3300u

static uint16_t circle[PAIRS][2];
static volatile uint32_t sum[2], pairs, alarms;

static void send(const struct line *line)
{
    for (const char *at = line->text; *at; ++at) {
        while (!(USART1->SR & USART_SR_TXE)) {
        }
        USART1->DR = (uint8_t)*at;
    }
}

static void say(const char *what, uint32_t value, const char *unit)
{
    struct line line = EMPTY_LINE;
    line_text(&line, what);
    line_decimal(&line, value);
    line_text(&line, unit);
    line_text(&line, "\r\n");
    send(&line);
}

// --- One reading a call

static uint16_t read_once(unsigned channel)
{
    ADC1->CR1 = 0;
    ADC1->SQR1 = 0;
    ADC1->SQR3 = channel;
    ADC1->SMPR1 = 7u << 18 | 7u << 21;
    ADC1->SMPR2 = 4u << 3 * (channel % 10);
    ADC1->CR2 = ADC_CR2_TSVREFE | ADC_CR2_EXTTRIG | ADC_BY_SOFTWARE << ADC_CR2_EXTSEL_SHIFT | ADC_CR2_ADON;
    wait_cycles(72 * 10); // the sensor takes up to 10 us to start
    ADC1->CR2 |= ADC_CR2_RSTCAL;
    while (ADC1->CR2 & ADC_CR2_RSTCAL) {
    }
    ADC1->CR2 |= ADC_CR2_CAL;
    while (ADC1->CR2 & ADC_CR2_CAL) {
    }
    ADC1->CR2 |= ADC_CR2_SWSTART;
    while (!(ADC1->SR & ADC_SR_EOC)) {
    }
    uint16_t value = (uint16_t)ADC1->DR;
    ADC1->CR2 = 0;
    return value;
}

// --- A stream

static void add(uint32_t from, uint32_t to)
{
    for (; from < to; ++from) {
        sum[0] += circle[from][0];
        sum[1] += circle[from][1];
        ++pairs;
    }
}

void DMA1_Channel1_IRQHandler(void)
{
    uint32_t flags = DMA1->ISR;
    DMA1->IFCR = flags & 0xF;
    if (flags & DMA_HTIF(DMA_ADC1))
        add(0, PAIRS / 2);
    if (flags & DMA_TCIF(DMA_ADC1))
        add(PAIRS / 2, PAIRS);
}

void ADC1_2_IRQHandler(void)
{
    ADC1->SR = ~ADC_SR_AWD;
    ++alarms;
    pin_write(GPIOC, LED, false);
}

static void start_stream(void)
{
    DMA1_CHANNEL(DMA_ADC1)->CPAR = (uint32_t)(uintptr_t)&ADC1->DR;
    DMA1_CHANNEL(DMA_ADC1)->CMAR = (uint32_t)(uintptr_t)circle;
    DMA1_CHANNEL(DMA_ADC1)->CNDTR = 2 * PAIRS;
    DMA1_CHANNEL(DMA_ADC1)->CCR = DMA_CCR_MINC | DMA_CCR_CIRC | DMA_CCR_HTIE | DMA_CCR_TCIE | 1u << DMA_CCR_PSIZE_SHIFT |
                                  1u << DMA_CCR_MSIZE_SHIFT | DMA_CCR_EN;
    irq_line_enable(DMA1_CHANNEL1_IRQ);
    ADC1->SQR1 = 1u << 20;
    ADC1->SQR3 = 0u | 1u << 5;
    ADC1->SMPR2 = 3u | 3u << 3;
    ADC1->LTR = 1000u * 4096u / FULL_MV;
    ADC1->HTR = 2500u * 4096u / FULL_MV;
    ADC1->CR1 = ADC_CR1_SCAN | ADC_CR1_AWDEN | ADC_CR1_AWDSGL | 1u | ADC_CR1_AWDIE;
    ADC1->CR2 = ADC_CR2_DMA | ADC_CR2_EXTTRIG | ADC_BY_TIM3_TRGO << ADC_CR2_EXTSEL_SHIFT | ADC_CR2_ADON;
    irq_line_enable(ADC1_2_IRQ);
    TIM3->ARR = 7200 - 1;
    TIM3->CR2 = TIM_TRGO_UPDATE << TIM_CR2_MMS_SHIFT;
    TIM3->CR1 = TIM_CR1_CEN;
}

static uint32_t mean_mv(uint32_t total, uint32_t count) { return count ? total * (FULL_MV / 4) / count / 1024 : 0; }

int main(void)
{
    clock_72mhz();
    cycles_start();
    RCC->CFGR |= 2u << RCC_CFGR_ADCPRE_SHIFT; // 12 MHz
    RCC->AHBENR |= RCC_AHB_DMA1;
    RCC->APB1ENR |= RCC_APB1_TIM3;
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_GPIOC | RCC_APB2_ADC1 | RCC_APB2_USART1;
    pin_mode(GPIOA, 0, PIN_ANALOG);
    pin_mode(GPIOA, 1, PIN_ANALOG);
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    pin_write(GPIOC, LED, true);
    pin_mode(GPIOC, LED, PIN_OUTPUT);
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE;
    uint32_t reference = read_once(ADC_VREFINT);
    say("supply ", 1200u * 4095u / reference, " mV");
    say("sensor ", read_once(ADC_SENSOR), "");
    say("PA0 ", read_once(0), "");
    start_stream();
    for (uint32_t start = cycles();;) {
        start = wait_cycles_from(start, 720000);
        irq_line_disable(DMA1_CHANNEL1_IRQ);
        uint32_t first = sum[0], second = sum[1], count = pairs;
        sum[0] = sum[1] = pairs = 0;
        irq_line_enable(DMA1_CHANNEL1_IRQ);
        struct line line = EMPTY_LINE;
        line_decimal(&line, count);
        line_text(&line, " pairs, ");
        line_decimal(&line, mean_mv(first, count));
        line_text(&line, " mV, ");
        line_decimal(&line, mean_mv(second, count));
        line_text(&line, " mV, alarms ");
        line_decimal(&line, alarms);
        line_text(&line, "\r\n");
        send(&line);
    }
}
