// SPDX-License-Identifier: GPL-2.0-or-later
//
// The FIFOs of a USART that hears itself on one wire (RM0433, section 48): how many words fit, thresholds and their
// interrupts, overrun, flushing, the prescaler, the choice of the kernel clock. Uses USART2 at PD5, to which nothing is
// attached on a Nucleo-144.

#include "check.h"
#include "h753/blocks.h"
#include "h753/clock.h"
#include "h753/handlers.h"

#define DIVIDER 130u // 923077 baud at 120 MHz
#define BIT (4 * DIVIDER)
#define WORD (10 * BIT)
#define LEVELS (ISR_RXFF | ISR_RXFT | ISR_TXFE | ISR_TXFT | USART_ISR_TXE | USART_ISR_RXNE)

enum { TX = 5, AF_USART2 = 7 };

static volatile uint32_t interrupts, idles, taken;
static volatile uint8_t heard[32];

void USART2_IRQHandler(void)
{
    ++interrupts;
    USART2->CR3 &= ~(uint32_t)CR3_TXFTIE;
    if (USART2->ISR & USART2->CR1 & ISR_IDLE)
        ++idles;
    USART2->ICR = ISR_IDLE;
    while (USART2->ISR & USART_ISR_RXNE)
        heard[taken++ % sizeof heard] = (uint8_t)USART2->RDR;
}

static void open(uint32_t cr1, uint32_t cr2, uint32_t cr3)
{
    USART2->CR1 = 0;
    USART2->CR2 = cr2;
    USART2->CR3 = cr3 | CR3_HDSEL;
    USART2->BRR = DIVIDER;
    USART2->CR1 = cr1;
    USART2->CR1 = cr1 | USART_CR1_UE | USART_CR1_TE | USART_CR1_RE;
    wait_cycles(14 * BIT); // the idle frame before the first word
}

static void send(uint32_t count)
{
    for (uint32_t word = 0; word < count; ++word) {
        while (!(USART2->ISR & USART_ISR_TXE)) {
        }
        USART2->TDR = word;
    }
    while (!(USART2->ISR & USART_ISR_TC)) {
    }
    wait_cycles(BIT);
}

static void after_reset(void)
{
    check_equal("ISR", USART2->ISR & ~0x400u, ISR_TCBGT | USART_ISR_TC | USART_ISR_TXE);
    USART2->CR1 = CR1_FIFOEN;
    check_equal("ISR-with-FIFOs", USART2->ISR & ~0x400u, ISR_TXFE | ISR_TCBGT | USART_ISR_TC | USART_ISR_TXE);
    check_equal("PRESC", USART2->PRESC, 0);
    open(CR1_FIFOEN, 0, 0);
    USART2->CR1 &= ~(uint32_t)CR1_FIFOEN;
    check("FIFOEN-is-locked", USART2->CR1 & CR1_FIFOEN);
    check_equal("empty", USART2->ISR & LEVELS, ISR_TXFE | ISR_TXFT | USART_ISR_TXE);
}

static void room_to_send(void)
{
    open(CR1_FIFOEN, 0, CR3_TXFTCFG(5));
    uint32_t start = DWT->CYCCNT, words = 0, clear = 0;
    while (USART2->ISR & USART_ISR_TXE) {
        USART2->TDR = words++;
        clear |= USART2->ISR & ISR_TXFE ? 0 : 1;
    }
    check_equal("one-under-way-and-sixteen", words, 17);
    check_equal("TXFE-is-cleared", clear, 1);
    while (!(USART2->ISR & ISR_TXFT)) {
    }
    check_range("empty-after-sixteen-words", DWT->CYCCNT - start, 16 * WORD - BIT, 16 * WORD + BIT);
    while (!(USART2->ISR & USART_ISR_TC)) {
    }
    check_range("without-a-gap", DWT->CYCCNT - start, 17 * WORD - BIT, 17 * WORD + BIT);
}

static void room_to_receive(void)
{
    open(CR1_FIFOEN, 0, CR3_RXFTCFG(2));
    send(7);
    check_equal("below-half", USART2->ISR & (ISR_RXFT | USART_ISR_RXNE), USART_ISR_RXNE);
    send(1);
    check_equal("half", USART2->ISR & ISR_RXFT, ISR_RXFT);
    uint32_t sum = 0;
    for (uint32_t word = 0; word < 7; ++word)
        sum = 10 * sum + USART2->RDR;
    check_equal("in-order", sum, 123456);
    check_equal("one-is-left", USART2->ISR & (ISR_RXFT | USART_ISR_RXNE), USART_ISR_RXNE);
    check_equal("the-last", USART2->RDR, 0);
    check_equal("none", USART2->ISR & USART_ISR_RXNE, 0);
    send(16);
    check_equal("not-yet-full", USART2->ISR & (ISR_RXFF | USART_ISR_ORE), 0);
    send(1);
    check_equal("full", USART2->ISR & (ISR_RXFF | USART_ISR_ORE), ISR_RXFF);
    send(1);
    check_equal("overrun", USART2->ISR & USART_ISR_ORE, USART_ISR_ORE);
    USART2->ICR = USART_ICR_ORECF;
    USART2->RQR = RQR_RXFRQ;
    check_equal("flushed", USART2->ISR & (ISR_RXFF | USART_ISR_ORE | USART_ISR_RXNE), 0);
    open(CR1_FIFOEN, 0, CR3_OVRDIS);
    send(3);
    check_equal("passed-by", USART2->RDR, 2);
    check_equal("nothing-behind-it", USART2->ISR & USART_ISR_RXNE, 0);
}

static void by_interrupt(void)
{
    open(CR1_FIFOEN, 0, CR3_RXFTCFG(1) | CR3_RXFTIE);
    interrupt_enable(USART2_IRQ, 5);
    interrupts = taken = 0;
    send(12);
    check_equal("one-for-four-words", interrupts, 3);
    check_equal("all-of-them", taken, 12);
    check_equal("as-sent", heard[11], 11);
    interrupts = 0;
    USART2->CR3 |= CR3_TXFTIE;
    DSB();
    check_equal("room-asks-for-words", interrupts, 1);
    USART2->CR1 |= CR1_IDLEIE;
    taken = 0;
    USART2->TDR = 99;
    wait_cycles(3 * WORD);
    check_equal("idle-after-a-word", idles, 1);
    check_equal("its-interrupt-finds-it", taken ? heard[0] : 0, 99);
    USART2->CR1 = 0;
}

static void timeout(void)
{
    open(CR1_FIFOEN, CR2_RTOEN, 0);
    USART2->RTOR = 30;
    send(3);
    wait_cycles(28 * BIT);
    check_equal("silence-too-short", USART2->ISR & ISR_RTOF, 0);
    wait_cycles(3 * BIT);
    check_equal("timeout", USART2->ISR & ISR_RTOF, ISR_RTOF);
}

static uint32_t cycles_of_ten_words(void)
{
    while (!(USART2->ISR & USART_ISR_TC)) {
    }
    uint32_t start = DWT->CYCCNT;
    for (uint32_t word = 0; word < 10; ++word)
        USART2->TDR = word;
    while (!(USART2->ISR & USART_ISR_TC)) {
    }
    return DWT->CYCCNT - start;
}

static void rates(void)
{
    USART2->CR1 = 0;
    USART2->PRESC = 2;
    open(CR1_FIFOEN, 0, 0);
    wait_cycles(4 * 14 * BIT);
    check_range("divided-by-four", cycles_of_ten_words(), 10 * 4 * WORD - 4 * BIT, 10 * 4 * WORD + 4 * BIT);
    USART2->PRESC = 0;
    check_equal("PRESC-is-locked", USART2->PRESC, 2);
    USART2->CR1 = 0;
    USART2->PRESC = 0;
    RCC->D2CCIP2R = RCC_USART234578_CSI;
    open(CR1_FIFOEN, 0, 0);
    wait_cycles(30 * 14 * BIT);
    check_range("4-MHz", cycles_of_ten_words(), 10 * 30 * WORD - 30 * BIT, 10 * 30 * WORD + 30 * BIT);
    RCC->D2CCIP2R = 0;
}

int main(void)
{
    counter_start();
    clock_start();
    RCC->AHB4ENR |= RCC_AHB4_GPIO('D');
    RCC->APB1LENR |= RCC_APB1L_USART2;
    (void)RCC->APB1LENR;
    pin_alternate('D', TX, AF_USART2);
    after_reset();
    room_to_send();
    room_to_receive();
    by_interrupt();
    timeout();
    rates();
    check_done();
}
