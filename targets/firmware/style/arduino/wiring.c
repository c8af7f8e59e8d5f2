// SPDX-License-Identifier: GPL-2.0-or-later
//
// What a core does before setup(), and the functions without a prefix. Single bits are set by the bit-band alias. Both converters
// are calibrated once; each analogRead is one conversion that software triggers.

#include "arduino.h"
#include "chip/adc.h"
#include "chip/stm32f103.h"
#include "clock.h"
#include "handlers.h"
#include "pin.h"

#define TICK_CYCLES 72000u
#define SAMPLE_55_5 5u

static volatile uint32_t uptime_ms;

void SysTick_Handler(void) { ++uptime_ms; }

uint32_t millis(void) { return uptime_ms; }

uint32_t micros(void)
{
    uint32_t ms, left;
    do {
        ms = uptime_ms;
        left = SYSTICK->VAL;
    } while (ms != uptime_ms);
    return ms * 1000 + (TICK_CYCLES - 1 - left) / 72;
}

void delay(uint32_t ms)
{
    for (uint32_t start = micros(); ms;)
        if (micros() - start >= 1000) {
            --ms;
            start += 1000;
        }
}

static port_t port_of(uint8_t pin)
{
    static const port_t ports[] = {GPIOA, GPIOB, GPIOC};
    return ports[pin / 16];
}

void pinMode(uint8_t pin, enum pin_use use)
{
    static const enum pin_mode modes[] = {
        [INPUT] = PIN_FLOATING, [INPUT_PULLUP] = PIN_PULLED,   [INPUT_ANALOG] = PIN_ANALOG,
        [OUTPUT] = PIN_OUTPUT,  [ALTERNATE] = PIN_ALTERNATE, [ALTERNATE_OPEN_DRAIN] = PIN_ALTERNATE_OPEN_DRAIN,
    };
    pin_mode(port_of(pin), pin % 16, modes[use]);
    if (use == INPUT_PULLUP)
        pin_write(port_of(pin), pin % 16, true);
}

void digitalWrite(uint8_t pin, enum level level) { pin_write(port_of(pin), pin % 16, level); }

static void adc_ready(volatile adc_t *adc, uint32_t gate)
{
    RCC->APB2ENR |= gate;
    RCC->APB2RSTR |= gate;
    RCC->APB2RSTR &= ~gate;
    adc->CR2 = ADC_BY_SOFTWARE << ADC_CR2_EXTSEL_SHIFT;
    *bit_of(&adc->CR2, 20) = 1; // EXTTRIG
    adc->SMPR1 = SAMPLE_55_5 * 0x249249u;
    adc->SMPR2 = SAMPLE_55_5 * 0x9249249u;
    *bit_of(&adc->CR2, 0) = 1; // ADON
    volatile uint32_t *reset = bit_of(&adc->CR2, 3), *calibrate = bit_of(&adc->CR2, 2);
    *reset = 1;
    while (*reset) {
    }
    *calibrate = 1;
    while (*calibrate) {
    }
}

uint16_t analogRead(uint8_t pin)
{
    ADC1->SQR1 = 0;
    ADC1->SQR3 = pin;               // PA0 to PA7 are channels 0 to 7
    *bit_of(&ADC1->CR2, 22) = 1; // SWSTART
    while (!*bit_of(&ADC1->SR, 1)) {
    }
    return (uint16_t)(ADC1->DR & 0xFFF);
}

void init(void)
{
    clock_72mhz();
    SYSTICK->LOAD = TICK_CYCLES - 1;
    SYSTICK->VAL = 0;
    SYSTICK->CTRL = SYSTICK_CLKSOURCE | SYSTICK_TICKINT | SYSTICK_ENABLE;
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOA | RCC_APB2_GPIOB | RCC_APB2_GPIOC;
    AFIO->MAPR = AFIO_MAPR_SWD_ONLY;
    RCC->CFGR |= 2u << RCC_CFGR_ADCPRE_SHIFT; // 12 MHz
    adc_ready(ADC1, RCC_APB2_ADC1);
    adc_ready(ADC2, RCC_APB2_ADC2);
}

int main(void)
{
    init();
    setup();
    for (;;)
        loop();
}
