// SPDX-License-Identifier: GPL-2.0-or-later
//
// ADC1 and ADC2 (RM0008, section 11). Outputs that are read back give 0 V and VDDA, the sensor and the reference inside the
// chip what stands between; no wire is needed. PA1, PA2 and PB0 must be free. HCLK is 8 MHz (HSI), ADCCLK 4 MHz.

#include "check.h"
#include "chip/adc.h"
#include "chip/stm32f103.h"
#include "cycles.h"
#include "handlers.h"
#include "pin.h"
#include "wait.h"

#define HIGH 1u // channel of PA1, which is driven high
#define LOW 2u  // channel of PA2, which is driven low
#define SIDE 8u // channel of PB0, which is driven high
#define SOFTWARE (ADC_CR2_EXTTRIG | ADC_BY_SOFTWARE << ADC_CR2_EXTSEL_SHIFT)
#define SOFTWARE_INJECTED (ADC_CR2_JEXTTRIG | ADC_BY_SOFTWARE << ADC_CR2_JEXTSEL_SHIFT)
#define CLOCK 2u // HCLK cycles of one of ADCCLK
#define FULL 4095u

static volatile uint32_t interrupts;
static volatile uint32_t seen;

void ADC1_2_IRQHandler(void)
{
    ++interrupts;
    seen = ADC1->SR;
    ADC1->SR = 0;
}

static void on(volatile adc_t *adc, uint32_t cr1, uint32_t cr2)
{
    adc->CR2 = 0;
    adc->SR = 0;
    adc->CR1 = cr1;
    adc->CR2 = cr2 | ADC_CR2_ADON;
    wait_cycles(16); // 2 us: t_STAB is 1 us
}

static void sequence(volatile adc_t *adc, unsigned count, const uint8_t *channels)
{
    uint32_t word[3] = {0, 0, 0};
    for (unsigned rank = 0; rank < count; ++rank)
        word[rank / 6] |= (uint32_t)channels[rank] << rank % 6 * 5;
    adc->SQR3 = word[0];
    adc->SQR2 = word[1];
    adc->SQR1 = word[2] | (count - 1) << 20;
}

#define SEQUENCE(adc, ...) sequence(adc, sizeof((uint8_t[]){__VA_ARGS__}), (const uint8_t[]){__VA_ARGS__})

static bool ended(volatile adc_t *adc) { return wait_until(adc->SR & ADC_SR_EOC); }

static uint32_t converted(unsigned channel)
{
    SEQUENCE(ADC1, (uint8_t)channel);
    ADC1->CR2 |= ADC_CR2_SWSTART;
    return ended(ADC1) ? ADC1->DR : 0xDEAD;
}

// --- Registers, power, calibration (11.3.1, 11.4, 11.12)

static void registers(void)
{
    check_equal("htr-reset", ADC1->HTR, 0xFFF);
    check_equal("cr2-reset", ADC1->CR2, 0);
    ADC1->SMPR2 = 0xFFFFFFFFu;
    check_equal("smpr2-has-30-bits", ADC1->SMPR2, 0x3FFFFFFF);
    ADC1->SMPR2 = 0;
    ADC1->SQR1 = 0xFFFFFFFFu;
    check_equal("sqr1-has-24-bits", ADC1->SQR1, 0x00FFFFFF);
    ADC1->SQR1 = 0;
    ADC1->SR = 0x1F;
    check_equal("flags-cannot-be-set", ADC1->SR, 0);
}

static void calibration(void)
{
    on(ADC1, 0, 0);
    ADC1->CR2 |= ADC_CR2_RSTCAL;
    check("rstcal-ends", wait_until(!(ADC1->CR2 & ADC_CR2_RSTCAL)));
    uint32_t start = cycles();
    ADC1->CR2 |= ADC_CR2_CAL;
    bool ends = wait_until(!(ADC1->CR2 & ADC_CR2_CAL));
    uint32_t took = cycles() - start;
    check("cal-ends", ends);
    check_range("cal-takes-83-clocks", took, 83 * CLOCK, 83 * CLOCK + 40);
}

// --- Single conversions (11.3.3 to 11.3.5)

static uint32_t taken(unsigned smp)
{
    ADC1->SMPR2 = smp << 3 * HIGH;
    SEQUENCE(ADC1, HIGH);
    uint32_t start = cycles();
    ADC1->CR2 |= ADC_CR2_SWSTART;
    ended(ADC1);
    uint32_t took = cycles() - start;
    ADC1->SMPR2 = 0;
    (void)ADC1->DR;
    return took;
}

static void single(void)
{
    on(ADC1, 0, SOFTWARE);
    check_equal("nothing-before-a-start", ADC1->SR, 0);
    check_equal("a-high-pin", converted(HIGH), FULL);
    check_equal("a-low-pin", converted(LOW), 0);
    check_equal("dr-clears-eoc", ADC1->SR, ADC_SR_STRT);
    check("swstart-clears-itself", !(ADC1->CR2 & ADC_CR2_SWSTART));
    ADC1->SR = ~ADC_SR_STRT;
    check_equal("strt-clears-by-0", ADC1->SR, 0);

    uint32_t slow = taken(7), fast = taken(0);
    check_range("239.5-and-12.5-clocks", slow, 252 * CLOCK, 252 * CLOCK + 40);
    check_range("1.5-and-12.5-clocks", fast, 14 * CLOCK, 14 * CLOCK + 40);
    check_range("they-differ-by-238-clocks", slow - fast, 238 * CLOCK - 24, 238 * CLOCK + 24);

    on(ADC1, 0, 0);
    SEQUENCE(ADC1, HIGH);
    ADC1->CR2 |= ADC_CR2_CONT;
    check("adon-with-another-bit-starts-nothing", !(ADC1->SR & ADC_SR_STRT));
    ADC1->CR2 &= ~ADC_CR2_CONT;
    ADC1->CR2 |= ADC_CR2_ADON;
    check("adon-once-more-starts", ended(ADC1));

    on(ADC1, 0, ADC_BY_SOFTWARE << ADC_CR2_EXTSEL_SHIFT);
    ADC1->CR2 |= ADC_CR2_SWSTART;
    check("swstart-needs-exttrig", !(ADC1->SR & ADC_SR_STRT));

    on(ADC1, 0, SOFTWARE | ADC_CR2_ALIGN);
    check_equal("left-alignment", converted(HIGH), 0xFFF0);
    ADC1->CR2 |= ADC_CR2_SWSTART;
    ADC1->CR2 = 0;
    wait_cycles(100);
    check("switched-off-it-does-not-end", !(ADC1->SR & ADC_SR_EOC));
}

static void inside(void)
{
    on(ADC1, 0, SOFTWARE | ADC_CR2_TSVREFE);
    ADC1->SMPR1 = 7u << 18 | 7u << 21;
    // 1.16 to 1.24 V, and 1.34 to 1.52 V at 25 degrees, of a VDDA of 3.3 V (DS5319)
    check_range("vrefint", converted(ADC_VREFINT), 1440, 1539);
    check_range("sensor", converted(ADC_SENSOR), 1300, 1887);
    ADC1->SMPR1 = 0;
}

// --- Groups (11.3.6 to 11.3.11)

static uint16_t buffer[8];

static void dma_into(uint32_t count, uint32_t more)
{
    DMA1_CHANNEL(DMA_ADC1)->CCR = 0;
    DMA1->IFCR = 0xF;
    DMA1_CHANNEL(DMA_ADC1)->CPAR = (uint32_t)(uintptr_t)&ADC1->DR;
    DMA1_CHANNEL(DMA_ADC1)->CMAR = (uint32_t)(uintptr_t)buffer;
    DMA1_CHANNEL(DMA_ADC1)->CNDTR = count;
    DMA1_CHANNEL(DMA_ADC1)->CCR = DMA_CCR_MINC | 1u << DMA_CCR_PSIZE_SHIFT | 1u << DMA_CCR_MSIZE_SHIFT | more | DMA_CCR_EN;
}

static void scan(void)
{
    on(ADC1, ADC_CR1_SCAN, SOFTWARE | ADC_CR2_DMA);
    SEQUENCE(ADC1, HIGH, LOW, SIDE, LOW);
    dma_into(4, 0);
    ADC1->CR2 |= ADC_CR2_SWSTART;
    bool all = wait_until(DMA1->ISR & DMA_TCIF(DMA_ADC1));
    check("dma-takes-a-scan", all);
    check_equal("dma-1", buffer[0], FULL);
    check_equal("dma-2", buffer[1], 0);
    check_equal("dma-3", buffer[2], FULL);
    check_equal("dma-4", buffer[3], 0);
    check_equal("eoc-is-cleared-by-dma", ADC1->SR, ADC_SR_STRT);

    on(ADC1, 0, SOFTWARE);
    ADC1->CR2 |= ADC_CR2_SWSTART;
    ended(ADC1);
    check_equal("without-scan-the-first-alone", ADC1->DR, FULL);

    on(ADC1, ADC_CR1_SCAN | ADC_CR1_DISCEN | 1u << ADC_CR1_DISCNUM_SHIFT, SOFTWARE | ADC_CR2_DMA);
    dma_into(8, 0);
    ADC1->CR2 |= ADC_CR2_SWSTART;
    wait_cycles(200);
    uint32_t left = DMA1_CHANNEL(DMA_ADC1)->CNDTR;
    check_equal("discontinuous-two-a-trigger", left, 6);
    ADC1->CR2 |= ADC_CR2_SWSTART;
    wait_cycles(200);
    check_equal("discontinuous-goes-on", buffer[2], FULL);
    check_equal("discontinuous-two-more", DMA1_CHANNEL(DMA_ADC1)->CNDTR, 4);

    on(ADC1, ADC_CR1_SCAN, SOFTWARE | ADC_CR2_DMA | ADC_CR2_CONT);
    SEQUENCE(ADC1, LOW, HIGH);
    dma_into(8, DMA_CCR_CIRC);
    ADC1->CR2 |= ADC_CR2_SWSTART;
    bool round = wait_until(DMA1->ISR & DMA_TCIF(DMA_ADC1));
    DMA1->IFCR = 0xF;
    bool again = wait_until(DMA1->ISR & DMA_TCIF(DMA_ADC1));
    check("continuous-goes-round", round && again);
    ADC1->CR2 = 0;
    DMA1_CHANNEL(DMA_ADC1)->CCR = 0;
    check_equal("continuous-keeps-the-order", buffer[0] | (uint32_t)buffer[7] << 16, FULL << 16);
}

static void injected(void)
{
    on(ADC1, ADC_CR1_SCAN, SOFTWARE | SOFTWARE_INJECTED);
    ADC1->JSQR = 1u << 20 | HIGH << 10 | LOW << 15; // two of them: JSQ3, JSQ4
    ADC1->JOFR[0] = 5;
    ADC1->JOFR[1] = 5;
    ADC1->CR2 |= ADC_CR2_JSWSTART;
    check("jeoc-rises", wait_until(ADC1->SR & ADC_SR_JEOC));
    check("jstrt-rises", ADC1->SR & ADC_SR_JSTRT);
    check("eoc-rises-with-it", ADC1->SR & ADC_SR_EOC); // "regular or injected" (11.12.1)
    check_equal("jdr1-less-its-offset", ADC1->JDR[0], FULL - 5);
    check_equal("jdr2-is-signed", ADC1->JDR[1], 0xFFFB);
    ADC1->JOFR[0] = ADC1->JOFR[1] = 0;

    on(ADC1, ADC_CR1_SCAN, SOFTWARE | SOFTWARE_INJECTED | ADC_CR2_DMA);
    SEQUENCE(ADC1, HIGH, LOW);
    dma_into(2, 0);
    ADC1->SMPR2 = 7u << 3 * LOW;
    ADC1->CR2 |= ADC_CR2_SWSTART;
    wait_cycles(100);
    uint32_t start = cycles();
    ADC1->SMPR2 = 0;
    ADC1->CR2 |= ADC_CR2_JSWSTART;
    bool first = wait_until(ADC1->SR & ADC_SR_JEOC);
    uint32_t took = cycles() - start;
    check("injected-breaks-off", first && took < 200 * CLOCK);
    check("the-regular-one-follows", wait_until(DMA1->ISR & DMA_TCIF(DMA_ADC1)));
    check_equal("its-values-are-whole", buffer[0] | (uint32_t)buffer[1] << 16, FULL);

    on(ADC1, ADC_CR1_SCAN | ADC_CR1_JAUTO, SOFTWARE);
    ADC1->CR2 |= ADC_CR2_SWSTART;
    check("jauto-converts-both-groups", wait_until(ADC1->SR & ADC_SR_JEOC));
}

// --- Watchdog, interrupts (11.3.7, 11.11)

static void watchdog(void)
{
    on(ADC1, ADC_CR1_AWDEN | ADC_CR1_AWDSGL | HIGH, SOFTWARE);
    ADC1->HTR = FULL;
    ADC1->LTR = FULL;
    converted(HIGH);
    check("inside-it-is-quiet", !(ADC1->SR & ADC_SR_AWD));
    ADC1->HTR = FULL - 1;
    converted(LOW);
    check("of-another-channel-it-is-quiet", !(ADC1->SR & ADC_SR_AWD));
    converted(HIGH);
    check("above-it-barks", ADC1->SR & ADC_SR_AWD);
    on(ADC1, ADC_CR1_AWDEN, SOFTWARE);
    ADC1->LTR = 1;
    converted(LOW);
    check("below-it-barks", ADC1->SR & ADC_SR_AWD);
    ADC1->HTR = 0xFFF;
    ADC1->LTR = 0;
}

static uint32_t interrupt_of(uint32_t enable, uint32_t start)
{
    on(ADC1, enable, SOFTWARE | SOFTWARE_INJECTED);
    interrupts = 0;
    irq_line_enable(ADC1_2_IRQ);
    ADC1->CR2 |= start;
    wait_cycles(300);
    irq_line_disable(ADC1_2_IRQ);
    irq_unpend(ADC1_2_IRQ);
    ADC1->SR = 0;
    return interrupts;
}

static void interrupt(void)
{
    check_equal("eocie", interrupt_of(ADC_CR1_EOCIE, ADC_CR2_SWSTART), 1);
    check("eoc-was-set", seen & ADC_SR_EOC);
    check_equal("jeocie", interrupt_of(ADC_CR1_JEOCIE, ADC_CR2_JSWSTART), 1);
    check_equal("jeocie-is-not-for-regular-ones", interrupt_of(ADC_CR1_JEOCIE, ADC_CR2_SWSTART), 0);
    check_equal("none-enabled", interrupt_of(0, ADC_CR2_SWSTART), 0);
}

// --- Triggers (11.7)

static uint32_t triggers_of(volatile tim_t *tim)
{
    tim->ARR = 999;
    tim->EGR = TIM_EGR_UG;
    dma_into(8, 0);
    tim->CNT = 0;
    tim->CR1 = TIM_CR1_CEN;
    wait_cycles(4600);
    tim->CR1 = 0;
    return 8 - DMA1_CHANNEL(DMA_ADC1)->CNDTR;
}

static void triggers(void)
{
    on(ADC1, 0, ADC_CR2_EXTTRIG | ADC_BY_TIM3_TRGO << ADC_CR2_EXTSEL_SHIFT | ADC_CR2_DMA);
    SEQUENCE(ADC1, HIGH);
    TIM3->CR2 = TIM_TRGO_UPDATE << TIM_CR2_MMS_SHIFT;
    check_equal("each-trgo-of-tim3", triggers_of(TIM3), 5); // that of UG among them

    on(ADC1, 0, ADC_CR2_EXTTRIG | ADC_BY_TIM2_CC2 << ADC_CR2_EXTSEL_SHIFT | ADC_CR2_DMA);
    TIM2->CCMR1 = (TIM_OC_PWM2) << 8;
    TIM2->CCR[1] = 500;
    TIM2->CCER = TIM_CCER_E(2);
    check_equal("each-rise-of-tim2-oc2", triggers_of(TIM2), 5);
    TIM2->CCER = 0;

    on(ADC1, 0, ADC_CR2_JEXTTRIG | ADC_INJECTED_BY_TIM2_TRGO << ADC_CR2_JEXTSEL_SHIFT);
    TIM2->CR2 = TIM_TRGO_UPDATE << TIM_CR2_MMS_SHIFT;
    TIM2->EGR = TIM_EGR_UG;
    check("an-injected-one-by-tim2", wait_until(ADC1->SR & ADC_SR_JEOC));

    on(ADC1, 0, ADC_CR2_EXTTRIG | ADC_BY_EXTI11 << ADC_CR2_EXTSEL_SHIFT);
    AFIO->EXTICR[2] = 1u << 12; // port B
    EXTI->FTSR = 1u << 11;
    EXTI->EMR = 1u << 11;
    pin_pull(GPIOB, 11, true);
    wait_cycles(50);
    check("no-edge-no-trigger", !(ADC1->SR & ADC_SR_STRT));
    pin_pull(GPIOB, 11, false);
    check("an-edge-of-exti-11", ended(ADC1));
    EXTI->FTSR = EXTI->EMR = 0;
}

// --- Both together (11.9)

static void dual(void)
{
    on(ADC2, ADC_CR1_SCAN, SOFTWARE | SOFTWARE_INJECTED);
    on(ADC1, ADC_CR1_SCAN | 6u << ADC_CR1_DUALMOD_SHIFT, SOFTWARE);
    SEQUENCE(ADC1, HIGH, LOW);
    SEQUENCE(ADC2, LOW, SIDE);
    ADC1->CR2 |= ADC_CR2_SWSTART;
    bool both = ended(ADC1) && ended(ADC2);
    check("regular-simultaneous", both);
    check_equal("both-in-one-word", ADC1->DR, FULL << 16);

    on(ADC1, ADC_CR1_SCAN | 5u << ADC_CR1_DUALMOD_SHIFT, SOFTWARE_INJECTED);
    on(ADC2, ADC_CR1_SCAN, SOFTWARE | SOFTWARE_INJECTED);
    ADC1->JSQR = HIGH << 15;
    ADC2->JSQR = SIDE << 15;
    ADC1->CR2 |= ADC_CR2_JSWSTART;
    bool pair = wait_until(ADC1->SR & ADC_SR_JEOC) && (ADC2->SR & ADC_SR_JEOC);
    check("injected-simultaneous", pair);
    check_equal("of-the-second", ADC2->JDR[0], FULL);

    on(ADC1, 9u << ADC_CR1_DUALMOD_SHIFT, SOFTWARE_INJECTED);
    on(ADC2, 0, SOFTWARE | SOFTWARE_INJECTED);
    ADC1->CR2 |= ADC_CR2_JSWSTART;
    wait_cycles(100);
    uint32_t first = (ADC1->SR & ADC_SR_JEOC) | (ADC2->SR & ADC_SR_JEOC) << 4;
    ADC1->SR = 0;
    ADC1->CR2 |= ADC_CR2_JSWSTART;
    wait_cycles(100);
    uint32_t second = (ADC1->SR & ADC_SR_JEOC) | (ADC2->SR & ADC_SR_JEOC) << 4;
    check_equal("alternate-first", first, ADC_SR_JEOC);
    check_equal("alternate-second", second, ADC_SR_JEOC << 4);

    on(ADC2, 0, SOFTWARE);
    on(ADC1, 7u << ADC_CR1_DUALMOD_SHIFT, SOFTWARE);
    SEQUENCE(ADC1, HIGH);
    SEQUENCE(ADC2, HIGH);
    ADC1->CR2 |= ADC_CR2_SWSTART;
    check("fast-interleaved", ended(ADC1) && (ADC2->SR & ADC_SR_EOC));
    ADC1->CR1 = 0;
    ADC1->CR2 = ADC2->CR2 = 0;
}

int main(void)
{
    cycles_start();
    RCC->AHBENR |= RCC_AHB_DMA1;
    RCC->APB1ENR |= RCC_APB1_TIM2 | RCC_APB1_TIM3;
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOA | RCC_APB2_GPIOB | RCC_APB2_ADC1 | RCC_APB2_ADC2;
    pin_write(GPIOA, 1, true);
    pin_mode(GPIOA, 1, PIN_OUTPUT);
    pin_write(GPIOA, 2, false);
    pin_mode(GPIOA, 2, PIN_OUTPUT);
    pin_write(GPIOB, 0, true);
    pin_mode(GPIOB, 0, PIN_OUTPUT);
    registers();
    calibration();
    single();
    inside();
    scan();
    injected();
    watchdog();
    interrupt();
    triggers();
    dual();
    check_done();
}
