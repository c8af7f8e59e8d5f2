// SPDX-License-Identifier: GPL-2.0-or-later

#include "vehicle_interface/board/joystick.h"

#include "vehicle_interface/chip/adc.h"
#include "vehicle_interface/chip/dma.h"
#include "vehicle_interface/chip/exti.h"
#include "vehicle_interface/chip/gpio.h"
#include "vehicle_interface/chip/irq.h"
#include "vehicle_interface/chip/rcc.h"
#include "vehicle_interface/options.h"

#define X_PIN 12
#define Y_PIN 11
#define SWITCH_PIN 13
#define X_CHANNEL 6u
#define Y_CHANNEL 2u

static const struct stream STREAM = {DMA2, 0, REQUEST_ADC1};

static volatile uint32_t counts[2]; // X and Y, in the order of the scan

// Out of deep power-down, then the regulator (RM0433, section 25.4.6). Not calibrated, as in the original: the joystick's own
// figures were taken so.
static void power_up(void)
{
    ADC1->CR = ADC_CR_ADVREGEN; // DEEPPWD is cleared by that
    while (!(ADC1->ISR & ADC_ISR_LDORDY)) {
    }
    ADC1->ISR = ADC_ISR_ADRDY;
    ADC1->CR |= ADC_CR_ADEN;
    while (!(ADC1->ISR & ADC_ISR_ADRDY)) {
    }
}

static void start_converter(void)
{
    RCC->AHB1ENR |= RCC_AHB1_ADC12 | RCC_AHB1_DMA2;
    (void)RCC->AHB1ENR;
    pin_mode(GPIO('F'), X_PIN, PIN_ANALOG);
    pin_mode(GPIO('F'), Y_PIN, PIN_ANALOG);
    ADC12_CCR = ADC_CCR_PRESC_256; // of PLL2's P output, which RCC gives it after a reset
    power_up();
    ADC1->PCSEL = 1u << X_CHANNEL | 1u << Y_CHANNEL;
    ADC1->SMPR[0] = ADC_SMPR(X_CHANNEL, ADC_SMP_387_5) | ADC_SMPR(Y_CHANNEL, ADC_SMP_387_5);
    ADC1->SQR[0] = ADC_SQR1(2u, X_CHANNEL, Y_CHANNEL);
    ADC1->CFGR = ADC_CFGR_DMA_CIRCULAR | ADC_CFGR_CONT;
    stream_begin(STREAM, &ADC1->DR, counts, 2, DMA_CR_CIRC | DMA_CR_WORDS);
    ADC1->CR |= ADC_CR_ADSTART;
}

static void start_switch(void)
{
    pin_pull_up(GPIO('F'), SWITCH_PIN);
    pin_mode(GPIO('F'), SWITCH_PIN, PIN_INPUT);
    RCC->APB4ENR |= RCC_APB4_SYSCFG;
    (void)RCC->APB4ENR;
    exti_port(SWITCH_PIN, 'F');
    EXTI->RTSR1 |= 1u << SWITCH_PIN;
    EXTI->CPUPR1 = 1u << SWITCH_PIN;
    EXTI->CPUIMR1 |= 1u << SWITCH_PIN;
    irq_enable_line(EXTI15_10_IRQ, LEVEL_SWITCH);
}

void EXTI15_10_IRQHandler(void)
{
    EXTI->CPUPR1 = 1u << SWITCH_PIN;
    joystick_released();
}

void joystick_start(void)
{
    RCC->AHB4ENR |= RCC_AHB4_GPIO('F');
    (void)RCC->AHB4ENR;
    start_converter();
    start_switch();
}

uint16_t joystick_x(void) { return (uint16_t)counts[DEFECT_AXES_SWAPPED ? 1 : 0]; }

uint16_t joystick_y(void) { return (uint16_t)counts[DEFECT_AXES_SWAPPED ? 0 : 1]; }
