// SPDX-License-Identifier: GPL-2.0-or-later
//
// DMA1 (RM0008, section 13): widths, increments, circular mode, flags, priorities, errors, requests of USART and timer.

#include "check.h"
#include "chip/stm32f103.h"
#include "clock.h"
#include "cycles.h"
#include "handlers.h"
#include "memory.h"
#include "pin.h"
#include "wait.h"

#define NOWHERE 0x60000000u // external memory, which this chip has not

enum width { BYTE, HALF, WORD };

static uint32_t source[16];
static uint32_t target[16];

static uint32_t at(volatile const void *address) { return (uint32_t)(uintptr_t)address; }

static void start(unsigned n, volatile const void *peripheral, volatile const void *memory, uint32_t count, uint32_t ccr)
{
    volatile dma_channel_t *channel = DMA1_CHANNEL(n);
    channel->CCR = 0;
    DMA1->IFCR = DMA_GIF(n);
    channel->CPAR = at(peripheral);
    channel->CMAR = at(memory);
    channel->CNDTR = count;
    channel->CCR = ccr | DMA_CCR_EN;
}

static bool complete(unsigned n) { return wait_until(DMA1->ISR & DMA_TCIF(n)); }

// --- Registers

static void registers(void)
{
    volatile dma_channel_t *channel = DMA1_CHANNEL(1);
    check_equal("isr-reset", DMA1->ISR, 0);
    check_equal("ccr-reset", channel->CCR, 0);
    channel->CNDTR = 0x12345;
    check_equal("cndtr-has-16-bits", channel->CNDTR, 0x2345);
    channel->CNDTR = 0;
    channel->CMAR = 0x20001234;
    check_equal("cmar-reads-back", channel->CMAR, 0x20001234);
}

// --- Memory to memory, with the source as "peripheral" (13.3.3), and the widths of table 76

static uint32_t copy(enum width from, enum width to, uint32_t count)
{
    for (unsigned i = 0; i < 16; ++i)
        source[i] = 0xB3B2B1B0 + i * 0x04040404;
    memset(target, 0xEE, sizeof target);
    start(1, source, target, count,
          DMA_CCR_MEM2MEM | DMA_CCR_PINC | DMA_CCR_MINC | from << DMA_CCR_PSIZE_SHIFT | to << DMA_CCR_MSIZE_SHIFT);
    return complete(1);
}

static void memory_to_memory(void)
{
    check("mem2mem-completes", copy(WORD, WORD, 4));
    check_equal("cndtr-counts-to-0", DMA1_CHANNEL(1)->CNDTR, 0);
    check_equal("words-copied", (uint32_t)memcmp(source, target, 16), 0);
    check_equal("no-more-than-asked", target[4], 0xEEEEEEEE);
    check_equal("flags-after-transfer", DMA1->ISR & 0xF, DMA_GIF(1) | DMA_TCIF(1) | DMA_HTIF(1));
    check_equal("en-stays-set", DMA1_CHANNEL(1)->CCR & DMA_CCR_EN, DMA_CCR_EN);
    check_equal("cmar-is-unchanged", DMA1_CHANNEL(1)->CMAR, at(target));
    DMA1->IFCR = DMA_HTIF(1);
    check_equal("ifcr-clears-one", DMA1->ISR & 0xF, DMA_GIF(1) | DMA_TCIF(1));
    DMA1->IFCR = DMA_GIF(1);
    check_equal("cgif-clears-all", DMA1->ISR & 0xF, 0);

    copy(BYTE, BYTE, 3);
    check_equal("bytes-copied", target[0], 0xEEB2B1B0);
    copy(HALF, HALF, 3);
    check_equal("half-words-copied", target[1], 0xEEEEB5B4);
    copy(BYTE, HALF, 2);
    check_equal("byte-to-half-word", target[0], 0x00B100B0);
    copy(BYTE, WORD, 2);
    check_equal("byte-to-word", target[1], 0x000000B1);
    copy(HALF, BYTE, 4);
    check_equal("half-word-to-byte", target[0], 0xB6B4B2B0);
    copy(HALF, WORD, 2);
    check_equal("half-word-to-word", target[1], 0x0000B3B2);
    copy(WORD, BYTE, 2);
    check_equal("word-to-byte", target[0], 0xEEEEB4B0);
    copy(WORD, HALF, 2);
    check_equal("word-to-half-word", target[0], 0xB5B4B1B0);

    memset(target, 0, sizeof target);
    source[0] = 0x01020304;
    start(1, source, target, 4, DMA_CCR_MEM2MEM | DMA_CCR_MINC | WORD << DMA_CCR_PSIZE_SHIFT | WORD << DMA_CCR_MSIZE_SHIFT);
    complete(1);
    check("no-pinc-fills", target[0] == source[0] && target[3] == source[0]);

    DMA1_CHANNEL(1)->CNDTR = 5;
    check_equal("cndtr-is-read-only-while-enabled", DMA1_CHANNEL(1)->CNDTR, 0);
    DMA1_CHANNEL(1)->CCR = 0;
}

// --- Two channels at once: the one with the higher priority is done first (13.3.2)

static uint32_t first_done;
static volatile uint32_t completions;

static void done_channel(unsigned n)
{
    if (completions++ == 0)
        first_done = n;
    DMA1->IFCR = DMA_TCIF(n);
}

void DMA1_Channel2_IRQHandler(void) { done_channel(2); }
void DMA1_Channel3_IRQHandler(void) { done_channel(3); }

static void priorities(void)
{
    const uint32_t bulk = DMA_CCR_MEM2MEM | DMA_CCR_PINC | WORD << DMA_CCR_PSIZE_SHIFT | WORD << DMA_CCR_MSIZE_SHIFT | DMA_CCR_TCIE;
    irq_line_enable(DMA1_CHANNEL1_IRQ + 1);
    irq_line_enable(DMA1_CHANNEL1_IRQ + 2);
    completions = 0;
    // The first has 600 words to go when the other, more urgent, starts with 100: it has to stand back
    start(2, (const void *)FLASH_BASE, &target[0], 600, bulk);
    start(3, (const void *)FLASH_BASE, &target[1], 100, bulk | 3u << DMA_CCR_PL_SHIFT);
    check("both-complete", wait_until(completions == 2));
    check_equal("higher-priority-first", first_done, 3);
    DMA1_CHANNEL(2)->CCR = 0;
    DMA1_CHANNEL(3)->CCR = 0;
}

// --- Errors (13.3.5): the channel is switched off

static void errors(void)
{
    start(4, (const void *)NOWHERE, target, 4, DMA_CCR_MEM2MEM | DMA_CCR_TEIE);
    check("teif", wait_until(DMA1->ISR & DMA_TEIF(4)));
    check_equal("error-clears-en", DMA1_CHANNEL(4)->CCR & DMA_CCR_EN, 0);
    check("teie-requests-interrupt", irq_is_pending(DMA1_CHANNEL1_IRQ + 3));
    check_equal("no-tcif-with-error", DMA1->ISR & DMA_TCIF(4), 0);
    DMA1->IFCR = DMA_GIF(4);
    irq_unpend(DMA1_CHANNEL1_IRQ + 3);
}

// --- A timer's update moves a word each period (table 78: TIM3_UP, channel 3)

static void timer_requests(void)
{
    static const uint32_t pattern[4] = {0x0020, 0x0000, 0x0060, 0x0040};
    RCC->APB1ENR |= RCC_APB1_TIM3;
    RCC->APB2ENR |= RCC_APB2_GPIOB;
    GPIOB->ODR = 0;
    irq_line_disable(DMA1_CHANNEL1_IRQ + 2);
    start(DMA_TIM3_UP, &GPIOB->ODR, pattern, 4,
          DMA_CCR_FROM_MEMORY | DMA_CCR_MINC | DMA_CCR_CIRC | WORD << DMA_CCR_PSIZE_SHIFT | WORD << DMA_CCR_MSIZE_SHIFT);
    TIM3->ARR = 999;
    TIM3->EGR = TIM_EGR_UG;
    TIM3->SR = 0;
    TIM3->DIER = TIM_DIER_UDE;
    TIM3->CR1 = TIM_CR1_CEN;
    uint32_t wrong = 0;
    for (unsigned i = 0; i < 10; ++i) {
        wait_until(TIM3->SR & TIM_UIF);
        TIM3->SR = 0;
        wait_cycles(100);
        wrong += GPIOB->ODR != pattern[i % 4];
    }
    TIM3->CR1 = 0;
    check_equal("timer-moves-pattern", wrong, 0);
    check_equal("circular-cndtr-reloads", DMA1_CHANNEL(DMA_TIM3_UP)->CNDTR, 2);
    check("half-and-complete-in-circular", (DMA1->ISR & (DMA_HTIF(3) | DMA_TCIF(3))) == (DMA_HTIF(3) | DMA_TCIF(3)));
    TIM3->DIER = 0;
    DMA1_CHANNEL(DMA_TIM3_UP)->CCR = 0;

    // From a register to memory: half-words of TIM3_CNT, asked for by TIM2
    static uint16_t counts[8];
    RCC->APB1ENR |= RCC_APB1_TIM2;
    TIM3->ARR = 0xFFFF;
    TIM3->EGR = TIM_EGR_UG;
    TIM3->CR1 = TIM_CR1_CEN;
    start(DMA_TIM2_UP, &TIM3->CNT, counts, 8,
          DMA_CCR_MINC | HALF << DMA_CCR_PSIZE_SHIFT | HALF << DMA_CCR_MSIZE_SHIFT);
    TIM2->ARR = 499;
    TIM2->EGR = TIM_EGR_UG;
    TIM2->DIER = TIM_DIER_UDE;
    TIM2->CR1 = TIM_CR1_CEN;
    check("register-to-memory-completes", complete(DMA_TIM2_UP));
    TIM2->CR1 = 0;
    TIM3->CR1 = 0;
    wrong = 0;
    for (unsigned i = 1; i < 8; ++i)
        wrong += (uint32_t)(uint16_t)(counts[i] - counts[i - 1] - 490) > 20;
    check_equal("one-count-each-500-cycles", wrong, 0);
    DMA1_CHANNEL(DMA_TIM2_UP)->CCR = 0;
}

// --- USART2 sends by itself, in circles (27.3.13, table 78: channel 7)

#define BIT 625u // of PCLK1 = 36 MHz: 57600 baud

static volatile uint32_t halves, wholes;

void DMA1_Channel7_IRQHandler(void)
{
    uint32_t flags = DMA1->ISR;
    halves += (flags & DMA_HTIF(7)) != 0;
    wholes += (flags & DMA_TCIF(7)) != 0;
    DMA1->IFCR = DMA_GIF(7);
}

static void usart_requests(void)
{
    static const uint8_t text[8] = "DMA1234";
    RCC->APB1ENR |= RCC_APB1_USART2;
    RCC->APB2ENR |= RCC_APB2_GPIOA;
    pin_mode(GPIOA, 2, PIN_ALTERNATE);
    USART2->BRR = BIT;
    USART2->CR1 = USART_CR1_UE | USART_CR1_TE;
    wait_cycles(2 * 12 * BIT);
    USART2->SR = 0; // TC
    start(DMA_USART2_TX, &USART2->DR, text, 8, DMA_CCR_FROM_MEMORY | DMA_CCR_MINC);
    check_equal("waits-for-dmat", DMA1_CHANNEL(DMA_USART2_TX)->CNDTR, 8);
    uint32_t begin = cycles();
    USART2->CR3 = USART_CR3_DMAT;
    bool handed_over = complete(DMA_USART2_TX);
    uint32_t at_tcif = cycles() - begin;
    uint32_t early = USART2->SR & USART_SR_TC;
    bool sent = wait_until(USART2->SR & USART_SR_TC);
    uint32_t at_tc = cycles() - begin;
    check("usart-transfer-completes", handed_over);
    // The last byte is handed over when the one before it leaves the holding register: six frames, the first two at once
    check_range("tcif-before-the-line-is-done", at_tcif, 59 * 2 * BIT, 62 * 2 * BIT);
    check_equal("tc-not-yet", early, 0);
    check("tc-in-the-end", sent);
    check_range("eight-frames-in-all", at_tc, 80 * 2 * BIT - 200, 82 * 2 * BIT);

    irq_line_enable(DMA1_CHANNEL1_IRQ + 6);
    halves = wholes = 0;
    start(DMA_USART2_TX, &USART2->DR, text, 8,
          DMA_CCR_FROM_MEMORY | DMA_CCR_MINC | DMA_CCR_CIRC | DMA_CCR_HTIE | DMA_CCR_TCIE);
    bool round = wait_until(wholes == 3);
    DMA1_CHANNEL(DMA_USART2_TX)->CCR = 0;
    check("goes-round-three-times", round);
    check_equal("half-way-interrupts", halves, 3);
    uint32_t left = DMA1_CHANNEL(DMA_USART2_TX)->CNDTR;
    wait_cycles(30 * 2 * BIT);
    check_equal("stops-when-disabled", DMA1_CHANNEL(DMA_USART2_TX)->CNDTR, left);
    USART2->CR3 = 0;
}

int main(void)
{
    clock_72mhz();
    cycles_start();
    RCC->AHBENR |= RCC_AHB_DMA1;
    registers();
    memory_to_memory();
    priorities();
    errors();
    timer_requests();
    usart_requests();
    check_done();
}
