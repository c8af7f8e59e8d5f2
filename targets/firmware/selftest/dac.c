// SPDX-License-Identifier: GPL-2.0-or-later
//
// The converters to analog of high-density devices (RM0008, section 12): data formats, triggers, DMA, noise, triangle. Needs
// no wire: what is put out stands in DOR, and as far as it is clearly high or low, at the pin that the port reads. Nothing
// may be attached to PA4, PA5 and PA9.

#include "check.h"
#include "chip/adc.h"
#include "clock.h"
#include "cycles.h"
#include "f103e/handlers.h"
#include "f103e/registers.h"
#include "pin.h"
#include "wait.h"

#define SETTLED 200u // cycles: three of APB1, what a program takes, and some

static void fresh(void)
{
    RCC->APB1RSTR = RCC_APB1_DAC;
    RCC->APB1RSTR = 0;
}

static void settle(void) { wait_cycles(SETTLED); }

static void triggered_by(enum dac_trigger trigger, uint32_t more)
{
    fresh();
    DAC->CR = DAC_CR_TEN | (uint32_t)trigger << DAC_CR_TSEL_SHIFT | more;
    DAC->CR |= DAC_CR_EN;
}

static uint32_t next_by_software(void)
{
    DAC->SWTRIGR = 1;
    settle();
    return DAC->DOR1;
}

// --- Registers and formats (12.3.3, 12.5)

static void registers(void)
{
    check_equal("cr-reset", DAC->CR, 0);
    check_equal("dor-reset", DAC->DOR1 | DAC->DOR2, 0);
    DAC->CR = ~0u;
    check_equal("cr-has-13-bits-a-channel", DAC->CR, 0x1FFF1FFF);
    fresh();
    check_equal("reset-by-rcc", DAC->CR, 0);
    DAC->DOR1 = 0x123;
    check_equal("dor-is-read-only", DAC->DOR1, 0);
}

static void formats(void)
{
    fresh();
    DAC->DHR12R1 = 0xFABC;
    settle();
    check_equal("right-12", DAC->DOR1, 0xABC);
    check_equal("one-channel-alone", DAC->DOR2, 0);
    DAC->DHR12L1 = 0x123F;
    settle();
    check_equal("left-12", DAC->DOR1, 0x123);
    DAC->DHR8R1 = 0x1AB;
    settle();
    check_equal("right-8", DAC->DOR1 >> 4, 0xAB);
    DAC->DHR12R2 = 0x456;
    settle();
    check_equal("right-12-of-2", DAC->DOR2, 0x456);
    DAC->DHR12L2 = 0x7890;
    settle();
    check_equal("left-12-of-2", DAC->DOR2, 0x789);
    DAC->DHR8R2 = 0xCD;
    settle();
    check_equal("right-8-of-2", DAC->DOR2 >> 4, 0xCD);
    DAC->DHR12RD = 0x07890123;
    settle();
    check_equal("right-12-of-both", DAC->DOR2 << 16 | DAC->DOR1, 0x07890123);
    DAC->DHR12LD = 0xABC0DEF0;
    settle();
    check_equal("left-12-of-both", DAC->DOR2 << 16 | DAC->DOR1, 0x0ABC0DEF);
    DAC->DHR8RD = 0x3412;
    settle();
    check_equal("right-8-of-both", DAC->DOR2 >> 4 << 8 | DAC->DOR1 >> 4, 0x3412);
    check_equal("works-without-en", DAC->CR, 0);
}

// --- Triggers (12.3.4, 12.3.6, table 74)

static void by_software(void)
{
    triggered_by(DAC_SOFTWARE, 0);
    DAC->DHR12R1 = 0x111;
    settle();
    check_equal("waits-for-its-trigger", DAC->DOR1, 0);
    check_equal("goes-by-swtrig", next_by_software(), 0x111);
    check_equal("swtrig-clears-itself", DAC->SWTRIGR, 0);
    DAC->CR |= DAC_CHANNEL_2(DAC_CR_EN | DAC_CR_TEN | DAC_SOFTWARE << DAC_CR_TSEL_SHIFT);
    DAC->DHR12RD = 0x03330222;
    DAC->SWTRIGR = 3;
    settle();
    check_equal("both-by-one-write", DAC->DOR2 << 16 | DAC->DOR1, 0x03330222);
    DAC->DHR12RD = 0x05550444;
    DAC->SWTRIGR = 2;
    settle();
    check_equal("each-by-its-bit", DAC->DOR2 << 16 | DAC->DOR1, 0x05550222);
    DAC->CR = DAC->CR & ~(7u << DAC_CR_TSEL_SHIFT);
    check_equal("tsel-stays-while-en", DAC->CR >> DAC_CR_TSEL_SHIFT & 7u, DAC_SOFTWARE);
    triggered_by(DAC_TIM6, 0);
    DAC->DHR12R1 = 0x111;
    check_equal("swtrig-is-not-for-others", next_by_software(), 0);
}

static void by_timer(const char *name, enum dac_trigger trigger, volatile tim_t *timer, volatile tim_t *other)
{
    triggered_by(trigger, 0);
    DAC->DHR12R1 = 0x200u + trigger;
    other->EGR = TIM_EGR_UG;
    settle();
    uint32_t before = DAC->DOR1;
    timer->EGR = TIM_EGR_UG; // MMS = 000: that is put out
    settle();
    check_equal(name, before << 16 | DAC->DOR1, 0x200u + trigger);
}

static void by_hardware(void)
{
    by_timer("trigger-tim6", DAC_TIM6, TIM6, TIM7);
    by_timer("trigger-tim8", DAC_TIM8, TIM8, TIM6);
    by_timer("trigger-tim7", DAC_TIM7, TIM7, TIM5);
    by_timer("trigger-tim5", DAC_TIM5, TIM5, TIM8);
    by_timer("trigger-tim2", DAC_TIM2, TIM2, TIM4);
    by_timer("trigger-tim4", DAC_TIM4, TIM4, TIM2);

    pin_pull(GPIOA, 9, false);
    EXTI->RTSR = 1u << 9;
    EXTI->EMR = 1u << 9;
    triggered_by(DAC_EXTI9, 0);
    DAC->DHR12R1 = 0x321;
    settle();
    uint32_t before = DAC->DOR1;
    pin_write(GPIOA, 9, true);
    settle();
    check_equal("trigger-exti9", before << 16 | DAC->DOR1, 0x321);
    DAC->DHR12R1 = 0x654;
    pin_write(GPIOA, 9, false);
    settle();
    check_equal("falling-edge-is-none", DAC->DOR1, 0x321);
    EXTI->RTSR = EXTI->EMR = 0;

    triggered_by(DAC_TIM6, 0);
    TIM6->CR2 = TIM_TRGO_ENABLE << TIM_CR2_MMS_SHIFT; // high while it counts
    TIM6->CR1 = TIM_CR1_CEN;
    settle();
    DAC->DHR12R1 = 0x654;
    TIM6->CR1 = 0;
    settle();
    check_equal("falling-trigger-is-none", DAC->DOR1, 0);
    TIM6->CR2 = 0;

    DAC->CR = 0;
    settle();
    check_equal("follows-without-ten", DAC->DOR1, 0x654);
}

// --- DMA2: channel 3 for the first, channel 4 for the second (12.3.7, table 79)

static volatile uint32_t halves, wholes;

void DMA2_Channel3_IRQHandler(void)
{
    uint32_t flags = DMA2->ISR;
    halves += (flags & DMA_HTIF(3)) != 0;
    wholes += (flags & DMA_TCIF(3)) != 0;
    DMA2->IFCR = DMA_GIF(3);
}

static void plays(unsigned channel, volatile const void *to, const uint16_t *words, uint32_t count, uint32_t more)
{
    volatile dma_channel_t *dma = DMA2_CHANNEL(channel);
    dma->CCR = 0;
    dma->CPAR = (uint32_t)(uintptr_t)to;
    dma->CMAR = (uint32_t)(uintptr_t)words;
    dma->CNDTR = count;
    more |= DMA_CCR_FROM_MEMORY | DMA_CCR_MINC | 1u << DMA_CCR_PSIZE_SHIFT | 1u << DMA_CCR_MSIZE_SHIFT;
    dma->CCR = more | DMA_CCR_EN;
}

static void by_dma(void)
{
    static const uint16_t words[4] = {0x100, 0x200, 0x300, 0x400};
    NVIC->ISER[1] = 1u << (DMA2_CHANNEL1_IRQ + 2 - 32);
    plays(3, &DAC->DHR12R1, words, 4, DMA_CCR_CIRC | DMA_CCR_HTIE | DMA_CCR_TCIE);
    triggered_by(DAC_SOFTWARE, DAC_CR_DMAEN);
    next_by_software();
    check_equal("software-asks-for-no-dma", DMA2_CHANNEL(3)->CNDTR, 4);
    triggered_by(DAC_TIM6, DAC_CR_DMAEN);
    uint32_t seen = 0;
    for (unsigned i = 0; i < 8; ++i) {
        TIM6->EGR = TIM_EGR_UG;
        settle();
        seen = seen << 4 | DAC->DOR1 >> 8;
    }
    check_equal("each-trigger-brings-the-next", seen, 0x01234123);
    check_equal("circle-of-dma", DMA2_CHANNEL(3)->CNDTR, 4);
    check_equal("half-and-whole-interrupts", halves << 8 | wholes, 0x202);
    DAC->CR &= ~DAC_CR_DMAEN;
    TIM6->EGR = TIM_EGR_UG;
    settle();
    check_equal("no-request-without-dmaen", DMA2_CHANNEL(3)->CNDTR, 4);

    fresh();
    plays(4, &DAC->DHR12R2, words, 2, 0);
    DAC->CR = DAC_CHANNEL_2(DAC_CR_EN | DAC_CR_TEN | DAC_CR_DMAEN | DAC_TIM7 << DAC_CR_TSEL_SHIFT);
    for (unsigned i = 0; i < 3; ++i) {
        TIM7->EGR = TIM_EGR_UG;
        settle();
    }
    check_equal("second-channel-by-channel-4", DMA2_CHANNEL(4)->CNDTR << 16 | DAC->DOR2, 0x200);
    DMA2_CHANNEL(3)->CCR = DMA2_CHANNEL(4)->CCR = 0;
    DMA2->IFCR = ~0u;
}

// A timer sets the pace: what TIM6 counts to, and no more
static void pace(void)
{
    static const uint16_t words[8] = {0x700, 0x600, 0x500, 0x400, 0x300, 0x200, 0x100, 0};
    plays(3, &DAC->DHR12R1, words, 8, 0);
    triggered_by(DAC_TIM6, DAC_CR_DMAEN);
    TIM6->CR2 = TIM_TRGO_UPDATE << TIM_CR2_MMS_SHIFT;
    TIM6->ARR = 719;
    uint32_t begin = cycles();
    TIM6->CR1 = TIM_CR1_CEN;
    wait_until(DMA2->ISR & DMA_TCIF(3));
    uint32_t took = cycles() - begin;
    TIM6->CR1 = 0;
    TIM6->CR2 = 0;
    settle();
    check_range("eight-words-in-eight-periods", took, 8 * 720 - 100, 8 * 720 + 100);
    check_equal("last-word-waits", DAC->DOR1, 0x100);
    DMA2_CHANNEL(3)->CCR = 0;
}

// --- Waves (12.3.8, 12.3.9)

static void noise(void)
{
    triggered_by(DAC_SOFTWARE, DAC_CR_NOISE | 11u << DAC_CR_MAMP_SHIFT);
    uint32_t first = next_by_software();
    check_equal("noise-begins", first << 16 | next_by_software(), 0x0AAA0D55);
    uint32_t wrong = 0, word = 0xD55;
    for (unsigned i = 0; i < 50; ++i) {
        uint32_t bit = (word ^ word >> 1 ^ word >> 4 ^ word >> 6) & 1u;
        word = word >> 1 | bit << 11;
        wrong += next_by_software() != word;
    }
    check_equal("noise-by-its-polynomial", wrong, 0);
    triggered_by(DAC_SOFTWARE, DAC_CR_NOISE | 3u << DAC_CR_MAMP_SHIFT);
    DAC->DHR12R1 = 0x500;
    check_equal("mamp-masks-noise", next_by_software(), 0x50A);
    DAC->CR &= ~DAC_CR_NOISE;
    check_equal("no-noise-without-wave", next_by_software(), 0x500);
    DAC->CR |= DAC_CR_NOISE;
    check_equal("wave-cleared-begins-anew", next_by_software(), 0x50A);
}

static void triangle(void)
{
    triggered_by(DAC_SOFTWARE, DAC_CR_TRIANGLE | 1u << DAC_CR_MAMP_SHIFT);
    DAC->DHR12R1 = 0x010;
    uint32_t seen = 0;
    for (unsigned i = 0; i < 8; ++i)
        seen = seen << 4 | (next_by_software() - 0x10);
    check_equal("triangle-up-and-down", seen, 0x01232101);
    triggered_by(DAC_SOFTWARE, DAC_CR_TRIANGLE | 5u << DAC_CR_MAMP_SHIFT);
    uint32_t most = 0;
    for (unsigned i = 0; i < 130; ++i) {
        uint32_t word = next_by_software();
        most = word > most ? word : most;
    }
    check_equal("amplitude", most, 63);
    triggered_by(DAC_SOFTWARE, DAC_CR_TRIANGLE | 3u << DAC_CR_MAMP_SHIFT);
    DAC->DHR12R1 = 0xFFE;
    seen = 0;
    for (unsigned i = 0; i < 4; ++i)
        seen = seen << 4 | (next_by_software() & 0xF);
    check_equal("sum-does-not-overflow", seen, 0xEFFF);
}

// --- The pin: EN connects it, whatever the port has configured (12.2)

static void outputs(void)
{
    fresh();
    pin_pull(GPIOA, 4, false);
    pin_pull(GPIOA, 5, true);
    DAC->DHR12RD = 0x00000FFF;
    settle();
    check_equal("pulls-rule-without-en", pin_read(GPIOA, 4) << 1 | pin_read(GPIOA, 5), 1);
    DAC->CR = DAC_CR_EN | DAC_CHANNEL_2(DAC_CR_EN);
    wait_cycles(2000); // 10 us, the longest wake-up, and the settling
    check_equal("en-connects-the-pins", pin_read(GPIOA, 4) << 1 | pin_read(GPIOA, 5), 2);
    DAC->DHR12RD = 0x0FFF0000;
    wait_cycles(2000);
    check_equal("pins-follow", pin_read(GPIOA, 4) << 1 | pin_read(GPIOA, 5), 1);
}

// --- A converter reads what is put out: channel 4 is PA4, channel 5 PA5 (11.3)

static uint32_t converted(uint32_t channel)
{
    ADC1->SQR3 = channel;
    ADC1->CR2 |= ADC_CR2_SWSTART;
    wait_until(ADC1->SR & ADC_SR_EOC);
    return ADC1->DR;
}

static void read_back(void)
{
    RCC->CFGR |= 2u << RCC_CFGR_ADCPRE_SHIFT; // 12 MHz
    RCC->APB2ENR |= RCC_APB2_ADC1;
    pin_mode(GPIOA, 4, PIN_ANALOG);
    pin_mode(GPIOA, 5, PIN_ANALOG);
    ADC1->SMPR2 = 7u << 12 | 7u << 15; // the longest, for both
    ADC1->CR2 = ADC_CR2_ADON | ADC_CR2_EXTTRIG | ADC_BY_SOFTWARE << ADC_CR2_EXTSEL_SHIFT;
    wait_cycles(1000);
    ADC1->CR2 |= ADC_CR2_CAL;
    wait_until(!(ADC1->CR2 & ADC_CR2_CAL));
    fresh();
    DAC->CR = DAC_CR_EN | DAC_CHANNEL_2(DAC_CR_EN);
    DAC->DHR12RD = 0x0C000400;
    wait_cycles(2000);
    check_range("adc-reads-a-quarter", converted(4), 0x400 - 40, 0x400 + 40);
    check_range("adc-reads-three-quarters", converted(5), 0xC00 - 40, 0xC00 + 40);
    ADC1->CR2 = 0;
}

int main(void)
{
    clock_72mhz();
    cycles_start();
    RCC->AHBENR |= RCC_AHB_DMA2;
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOA | RCC_APB2_TIM8;
    RCC->APB1ENR |= RCC_APB1_TIM2 | RCC_APB1_TIM4 | RCC_APB1_TIM5 | RCC_APB1_TIM6 | RCC_APB1_TIM7 | RCC_APB1_DAC;
    registers();
    formats();
    by_software();
    by_hardware();
    by_dma();
    pace();
    noise();
    triangle();
    outputs();
    read_back();
    check_done();
}
