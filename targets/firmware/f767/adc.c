// SPDX-License-Identifier: GPL-2.0-or-later
//
// ADC1 on what is inside the chip (RM0410, section 15): the reference, the battery, the sensor; times, groups, alignment,
// watchdog, overrun, DMA, a trigger. Nothing is needed at any pin; VDD and VDDA are 3.3 V, and VBAT is VDD, as on a Nucleo.

#include "check.h"
#include "f767/clock.h"
#include "f767/transfers.h"

#define ADC_CYCLES 8u // of HCLK: PCLK2 is half of it, and ADCCLK a quarter of that
#define LONG 7u       // 480 clocks of sampling
#define CONVERSION (492u * ADC_CYCLES)
#define VREFINT_CAL (*(volatile uint16_t *)0x1FF0F44Au) // at 3.3 V and 30 degrees (DS11532)

static uint16_t samples[8];

static void set_up(uint32_t cr1, uint32_t cr2)
{
    ADC1->CR2 = 0;
    ADC1->SR = 0;
    (void)ADC1->DR;
    ADC1->CR1 = cr1;
    ADC1->CR2 = cr2 | ADC_ON;
    wait_cycles(1000); // t_STAB
}

static void sequence(uint32_t count, uint32_t channels)
{
    ADC1->SQR[0] = (count - 1) << 20;
    ADC1->SQR[2] = channels;
}

static uint32_t cycles_to(uint32_t flag)
{
    uint32_t start = DWT->CYCCNT;
    while (!(ADC1->SR & flag)) {
        if (DWT->CYCCNT - start > 1000000u)
            return 0xFFFFFFFFu;
    }
    return DWT->CYCCNT - start;
}

static uint32_t convert(uint32_t channel)
{
    sequence(1, channel);
    ADC1->CR2 |= ADC_SWSTART;
    cycles_to(ADC_EOC);
    return ADC1->DR;
}

static void inside(void)
{
    ADC_CCR = ADC_PRESCALER_4 | ADC_TSVREFE;
    set_up(0, 0);
    wait_cycles(216u * 20u); // start-up of the sensor
    check_range("reference", convert(ADC_VREFINT), 1464, 1540); // 1.18 to 1.24 V
    check_range("sensor", convert(ADC_SENSOR), 850, 1200);      // about 0 to 100 degrees
    ADC_CCR |= ADC_VBATE;
    check_range("battery-divided-by-four", convert(ADC_SENSOR), 980, 1070);
    ADC_CCR &= ~(uint32_t)ADC_VBATE;
}

static void times(void)
{
    set_up(0, 0);
    sequence(1, ADC_VREFINT);
    ADC1->CR2 |= ADC_SWSTART;
    uint32_t took = cycles_to(ADC_EOC);
    check_range("492-clocks", took, CONVERSION - 100u, CONVERSION + 100u);
    check_equal("EOC-and-STRT", ADC1->SR, ADC_EOC | ADC_STRT);
    uint32_t value = ADC1->DR;
    check_equal("DR-clears-EOC", ADC1->SR, ADC_STRT);
    set_up(ADC_RES_8, 0);
    ADC1->CR2 |= ADC_SWSTART;
    took = cycles_to(ADC_EOC);
    check_range("488-clocks", took, 488u * ADC_CYCLES - 100u, 488u * ADC_CYCLES + 100u);
    check_range("eight-bits", ADC1->DR, (value >> 4) - 1u, (value >> 4) + 1u);
    set_up(0, ADC_ALIGN);
    check_range("left", convert(ADC_VREFINT), (value - 8u) << 4, (value + 8u) << 4);
}

static void groups(void)
{
    set_up(ADC_SCAN, ADC_EOCS);
    sequence(2, ADC_VREFINT | ADC_SENSOR << 5);
    ADC1->CR2 |= ADC_SWSTART;
    cycles_to(ADC_EOC);
    uint32_t first = ADC1->DR;
    cycles_to(ADC_EOC);
    check("scan", first > ADC1->DR + 200u);
    ADC1->JOFR[0] = 0xFFF;
    ADC1->JSQR = 1u << 20 | ADC_VREFINT << 10 | ADC_SENSOR << 15;
    ADC1->CR2 |= ADC_JSWSTART;
    check_range("injected-takes-both", cycles_to(ADC_JEOC), 2u * CONVERSION - 200u, 2u * CONVERSION + 200u);
    check_range("offset", ADC1->JDR[0], 0xFFFFu & (first - 0xFFFu - 16u), 0xFFFFu & (first - 0xFFFu + 16u));
    check_range("second", ADC1->JDR[1], 850, 1200);

    set_up(ADC_SCAN | ADC_DISCEN, 0);
    ADC1->CR2 |= ADC_SWSTART;
    cycles_to(ADC_EOC);
    check_range("discontinuous-1", ADC1->DR, 1464, 1540);
    wait_cycles(2u * CONVERSION);
    check_equal("it-waits", ADC1->SR & ADC_EOC, 0);
    ADC1->CR2 |= ADC_SWSTART;
    cycles_to(ADC_EOC);
    check_range("discontinuous-2", ADC1->DR, 850, 1200);
}

static void watchdog_and_overrun(void)
{
    set_up(ADC_AWDEN, 0);
    ADC1->HTR = 2000;
    ADC1->LTR = 1000;
    convert(ADC_VREFINT);
    check_equal("inside", ADC1->SR & ADC_AWD, 0);
    ADC1->HTR = 1200;
    convert(ADC_VREFINT);
    check_equal("above", ADC1->SR & ADC_AWD, ADC_AWD);
    set_up(ADC_SCAN, ADC_EOCS);
    sequence(2, ADC_VREFINT | ADC_SENSOR << 5);
    ADC1->CR2 |= ADC_SWSTART;
    wait_cycles(3u * CONVERSION);
    check_equal("overrun", ADC1->SR & ADC_OVR, ADC_OVR);
    check_equal("common-flags", ADC_CSR, ADC1->SR);
}

static void by_dma(void)
{
    RCC->AHB1ENR |= RCC_AHB1_DMA2;
    DMA2->S[0].PAR = (uint32_t)&ADC1->DR;
    DMA2->S[0].M0AR = (uint32_t)samples;
    DMA2->S[0].NDTR = 4;
    DMA2->S[0].CR = DMA_MINC | DMA_PSIZE(1) | DMA_MSIZE(1);
    DMA2->S[0].CR |= DMA_EN;
    set_up(ADC_SCAN, ADC_DMA | ADC_CONT);
    sequence(2, ADC_VREFINT | ADC_SENSOR << 5);
    ADC1->CR2 |= ADC_SWSTART;
    wait_cycles(8u * CONVERSION);
    check_range("dma", samples[2], 1464, 1540);
    check_equal("as-many-as-asked-for", samples[4], 0);
    check_equal("without-overrun", ADC1->SR & ADC_OVR, 0);
    ADC1->CR2 = 0;
}

static void by_trigger(void)
{
    RCC->APB1ENR |= RCC_APB1_TIM(6);
    TIM6->CR2 = 2u << 4; // TRGO is the update
    TIM6->ARR = 20000;
    set_up(ADC_EOCIE, ADC_EXTSEL_TIM6 | ADC_EXTEN_RISING);
    sequence(1, ADC_VREFINT);
    wait_cycles(2u * CONVERSION);
    check_equal("no-trigger-yet", ADC1->SR, 0);
    forget(ADC_IRQ);
    TIM6->CR1 = TIM_CEN;
    uint32_t took = cycles_to(ADC_EOC);
    check_range("trigger-then-conversion", took, 40000u + CONVERSION - 200u, 40000u + CONVERSION + 200u);
    check("interrupt", pending(ADC_IRQ));
}

int main(void)
{
    cycles_start();
    clock_start();
    RCC->APB2ENR |= RCC_APB2_ADC1;
    check_equal("HTR", ADC1->HTR, 0xFFF);
    ADC1->SMPR1 = LONG << 21 | LONG << 24;
    check_range("calibration", VREFINT_CAL, 1464, 1540);
    inside();
    times();
    groups();
    watchdog_and_overrun();
    by_dma();
    by_trigger();
    check_done();
}
