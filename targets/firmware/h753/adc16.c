// SPDX-License-Identifier: GPL-2.0-or-later
//
// ADC3 on what is inside the chip (RM0433, section 25), on a chip of revision V: supply, calibration, times, sequences,
// offset, oversampling, watchdog, overrun, DMA, a trigger. Nothing is needed at any pin; VREF+ is 3.3 V, and VBAT is VDD,
// as on a Nucleo.

#include "check.h"
#include "h753/blocks.h"
#include "h753/clock.h"
#include "h753/handlers.h"

#define CLOCK 240u // cycles of the CPU: 480 MHz, 64 MHz / 16, and half of that on revision V
#define LONG 6u    // 387.5 clocks of sampling
#define CONVERSION (396u * CLOCK)
#define READY ADC_REGULATOR
#define SWITCHES (ADC_VREFINT_ON | ADC_SENSOR_ON | ADC_VBAT_ON)
#define SLACK 200u

#define SAMPLES ((volatile uint32_t *)0x24000000u) // AXI SRAM: the DMA controllers do not reach DTCM

static volatile uint32_t interrupts;

void ADC3_IRQHandler(void)
{
    ++interrupts;
    ADC3->ISR = ADC_EOS;
}

static uint32_t cycles_to(uint32_t flag)
{
    uint32_t start = DWT->CYCCNT;
    while (!(ADC3->ISR & flag)) {
        if (DWT->CYCCNT - start > 100000000u)
            return 0xFFFFFFFFu;
    }
    return DWT->CYCCNT - start;
}

static void stop(void)
{
    if (ADC3->CR & ADC_START)
        ADC3->CR |= ADC_STOP;
    while (ADC3->CR & ADC_START) {
    }
    (void)ADC3->DR;
    ADC3->ISR = 0x7FE;
}

static void set_up(uint32_t cfgr, uint32_t cfgr2)
{
    stop();
    ADC3->CFGR = ADC_JQDIS | cfgr;
    ADC3->CFGR2 = cfgr2;
}

static void sequence(uint32_t count, uint32_t first, uint32_t second)
{
    ADC3->SQR[0] = (count - 1) | first << 6 | second << 12;
}

static uint32_t convert(uint32_t channel)
{
    sequence(1, channel, 0);
    ADC3->CR |= ADC_START;
    cycles_to(ADC_EOC);
    return ADC3->DR;
}

static void wake_up(void)
{
    check_equal("deep-power-down", ADC3->CR, 1u << 29);
    ADC3->CR = ADC_EN;
    check_equal("not-without-its-supply", ADC3->CR & ADC_EN, 0);
    ADC3->CR = 0;
    ADC3->CR = READY;
    check_range("regulator", cycles_to(ADC_LDORDY), 0, 10u * 480u);
    uint32_t start = DWT->CYCCNT;
    ADC3->CR = READY | ADC_CALIBRATE;
    while (ADC3->CR & ADC_CALIBRATE) {
    }
    check_range("offset-calibration", DWT->CYCCNT - start, 1280u * CLOCK - SLACK, 1280u * CLOCK + SLACK);
    ADC3_CCR = SWITCHES; // 64 MHz, and half of that
    ADC3->CR = READY | ADC_BOOST_50_MHZ;
    start = DWT->CYCCNT;
    ADC3->CR = READY | ADC_BOOST_50_MHZ | ADC_LINEAR | ADC_CALIBRATE;
    while (ADC3->CR & ADC_CALIBRATE) {
    }
    check_range("linearity", (DWT->CYCCNT - start) / (CLOCK / 16), 165000u, 165040u);
    check_equal("six-words-are-ready", ADC3->CR >> 22 & 0x3Fu, 0x3F);
    ADC3_CCR = ADC_PRESC_16 | SWITCHES;
    ADC3->CR |= ADC_EN;
    check("ADRDY", cycles_to(ADC_ADRDY) < 1000000u);
    ADC3->CR |= ADC_CALIBRATE;
    check_equal("no-calibration-now", ADC3->CR & ADC_CALIBRATE, 0);
}

static void inside(void)
{
    ADC3->SMPR[1] = 6u * 011111111111u;
    set_up(0, 0);
    check_range("reference", convert(CHANNEL_VREFINT), 23434, 24924); // 1.18 to 1.255 V (DS12117)
    check_range("sensor", convert(CHANNEL_SENSOR), 10000, 16000);     // about 0 to 100 degrees
    check_range("battery-divided-by-four", convert(CHANNEL_VBAT), 15700, 17000);
    set_up(ADC_12_BITS, 0);
    check_range("twelve-bits", convert(CHANNEL_VREFINT), 1464, 1558);
}

static void times(void)
{
    set_up(0, 0);
    sequence(1, CHANNEL_VREFINT, 0);
    ADC3->CR |= ADC_START;
    uint32_t sampled = cycles_to(ADC_EOSMP);
    uint32_t converted = cycles_to(ADC_EOC);
    check_range("387.5-clocks-of-sampling", (2u * sampled + CLOCK / 2) / CLOCK, 774, 776);
    check_range("8.5-clocks-of-conversion", converted, 17u * CLOCK / 2 - CLOCK / 4, 17u * CLOCK / 2 + CLOCK / 4);
    check_equal("EOC-and-EOS", ADC3->ISR & (ADC_EOC | ADC_EOS), ADC_EOC | ADC_EOS);
    check_equal("ADSTART-is-cleared", ADC3->CR & ADC_START, 0);
    (void)ADC3->DR;
    check_equal("DR-clears-EOC", ADC3->ISR & (ADC_EOC | ADC_EOS), ADC_EOS);
    set_up(ADC_8_BITS, 0);
    ADC3->CR |= ADC_START;
    cycles_to(ADC_EOSMP);
    check_range("4.5-clocks-for-eight-bits", cycles_to(ADC_EOC), 9u * CLOCK / 2 - CLOCK / 4, 9u * CLOCK / 2 + CLOCK / 4);
}

static void groups(void)
{
    set_up(0, 0);
    sequence(2, CHANNEL_VREFINT, CHANNEL_SENSOR);
    ADC3->CR |= ADC_START;
    cycles_to(ADC_EOC);
    uint32_t first = ADC3->DR;
    cycles_to(ADC_EOC);
    check("scan", first > ADC3->DR + 4000u);
    ADC3->OFR[0] = CHANNEL_VREFINT << 26 | 0x8000u;
    check_range("offset", convert(CHANNEL_VREFINT) + 0x8000u, first - 200u, first + 200u);
    ADC3->OFR[0] = 0;
    ADC3->JSQR = 1u | CHANNEL_SENSOR << 9 | CHANNEL_VREFINT << 15;
    ADC3->CR |= ADC_JSTART;
    check_range("injected", cycles_to(ADC_JEOS) / CLOCK, 2u * 396u - 4u, 2u * 396u + 4u);
    check_range("second", ADC3->JDR[1], first - 200u, first + 200u);
    set_up(0, 1u | 4u << 5 | 15u << 16);
    check_range("sixteen-times-a-sixteenth", convert(CHANNEL_VREFINT), first - 200u, first + 200u);
    set_up(ADC_WATCH_ALL, 0);
    ADC3->LTR1 = 0x1000;
    ADC3->HTR1 = 0x8000;
    convert(CHANNEL_VREFINT);
    check_equal("within", ADC3->ISR & ADC_AWD1, 0);
    ADC3->HTR1 = 0x4000;
    convert(CHANNEL_VREFINT);
    check_equal("above", ADC3->ISR & ADC_AWD1, ADC_AWD1);
}

static void overruns(void)
{
    set_up(ADC_CONTINUOUS, 0);
    sequence(2, CHANNEL_VREFINT, CHANNEL_SENSOR);
    ADC3->CR |= ADC_START;
    wait_cycles(5u * CONVERSION / 2);
    check_equal("overrun", ADC3->ISR & ADC_OVR, ADC_OVR);
    check_range("the-old-one-is-kept", ADC3->DR, 23434, 24924);
    set_up(ADC_CONTINUOUS | ADC_OVERWRITE, 0);
    ADC3->CR |= ADC_START;
    wait_cycles(5u * CONVERSION / 2);
    check_range("or-overwritten", ADC3->DR, 10000, 16000);
    stop();
}

static void by_dma(void)
{
    RCC->AHB1ENR |= RCC_AHB1_DMA2;
    DMAMUX1[8] = REQUEST_ADC3;
    DMA2->S[0].PAR = (uint32_t)&ADC3->DR;
    DMA2->S[0].M0AR = (uint32_t)SAMPLES;
    DMA2->S[0].NDTR = 2;
    DMA2->S[0].CR = DMA_MINC | DMA_WORDS | DMA_CIRC;
    DMA2->S[0].CR |= DMA_EN;
    set_up(ADC_CONTINUOUS | ADC_OVERWRITE | ADC_DMA_CIRCULAR, 0);
    sequence(2, CHANNEL_VREFINT, CHANNEL_SENSOR);
    ADC3->CR |= ADC_START;
    wait_cycles(7u * CONVERSION);
    check_range("round-and-round-1", SAMPLES[0], 23434, 24924);
    check_range("round-and-round-2", SAMPLES[1], 10000, 16000);
    check_equal("without-overrun", ADC3->ISR & ADC_OVR, 0);
    stop();
    DMA2->S[0].CR = 0;
    while (DMA2->S[0].CR & DMA_EN) {
    }
    SAMPLES[2] = 0;
    DMA2->LIFCR = DMA_ALL;
    DMA2->S[0].NDTR = 2;
    DMA2->S[0].CR = DMA_MINC | DMA_WORDS;
    DMA2->S[0].CR |= DMA_EN;
    set_up(ADC_CONTINUOUS | ADC_OVERWRITE | ADC_DMA_ONCE, 0);
    ADC3->CR |= ADC_START;
    wait_cycles(4u * CONVERSION);
    check_equal("as-many-as-asked-for", DMA2->LISR & DMA_TCIF, DMA_TCIF);
    check_equal("and-no-more", SAMPLES[2], 0);
    DMA2->LIFCR = DMA_ALL;
    DMA2->S[0].NDTR = 2;
    DMA2->S[0].CR |= DMA_EN;
    ADC3->ISR = ADC_OVR;
    wait_cycles(2u * CONVERSION);
    check_equal("nor-for-another-stream", DMA2->S[0].NDTR, 2);
    stop();
}

static void by_trigger(void)
{
    RCC->APB1LENR |= RCC_APB1L_TIM6;
    TIM6->CR2 = 2u << 4;               // TRGO is the update
    TIM6->ARR = 2u * CONVERSION / 8u; // at 240 MHz: four conversions
    TIM6->PSC = 7;
    TIM6->EGR = 1;
    set_up(ADC_BY_TIM6, 0);
    ADC3->IER = ADC_EOS;
    interrupt_enable(ADC3_IRQ, 4);
    sequence(1, CHANNEL_VREFINT, 0);
    ADC3->CR |= ADC_START;
    wait_cycles(2u * CONVERSION);
    check_equal("it-waits", interrupts, 0);
    TIM6->CR1 = 1;
    wait_cycles(14u * CONVERSION);
    check_equal("three-triggers", interrupts, 3);
    check_equal("ADSTART-stays", ADC3->CR & ADC_START, ADC_START);
    TIM6->CR1 = 0;
    ADC3->IER = 0;
    stop();
    ADC3->CR |= ADC_DIS;
    while (ADC3->CR & ADC_EN) {
    }
    check_equal("off", ADC3->CR & (ADC_EN | ADC_DIS), 0);
}

int main(void)
{
    counter_start();
    clock_start();
    RCC->AHB4ENR |= RCC_AHB4_ADC3;
    RCC->D3CCIPR = RCC_ADC_PER;
    (void)RCC->D3CCIPR;
    ADC3_CCR = ADC_PRESC_16 | SWITCHES;
    wake_up();
    wait_cycles(480u * 30u); // start-up of the sensor
    inside();
    times();
    groups();
    overruns();
    by_dma();
    by_trigger();
    check_done();
}
