// SPDX-License-Identifier: GPL-2.0-or-later
//
// A USART with ISR and ICR that hears itself on one wire (RM0410, section 34.5.16): rates, formats, flags, mute mode. Uses
// USART2 at PD5, to which nothing is attached on a Nucleo-144.

#include "check.h"
#include "f767/blocks.h"
#include "f767/clock.h"

#define BAUD 115200u
#define DIVIDER ((PCLK1_HZ + BAUD / 2) / BAUD)
#define BIT (4 * DIVIDER) // cycles of HCLK

enum { TX = 5, AF_USART2 = 7 };

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

static uint32_t flags(void) { return USART2->ISR & 0xFFu; }

static void send(uint32_t value)
{
    USART2->TDR = value;
    while (!(USART2->ISR & ISR_TC)) {
    }
}

static uint32_t loop(uint32_t value)
{
    send(value);
    wait_cycles(BIT);
    return USART2->RDR;
}

static void after_reset(void)
{
    check_equal("ISR", USART2->ISR & 0xFFFFFBFFu, ISR_TC | ISR_TXE);
    check_equal("CR1", USART2->CR1, 0);
    check_equal("BRR", USART2->BRR, 0);
    USART2->BRR = DIVIDER;
    USART2->CR1 = USART_CR1_UE | USART_CR1_TE;
    check_equal("TEACK", USART2->ISR & (ISR_TEACK | ISR_REACK), ISR_TEACK);
    USART2->CR1 |= USART_CR1_RE;
    check_equal("REACK", USART2->ISR & (ISR_TEACK | ISR_REACK), ISR_TEACK | ISR_REACK);
    USART2->BRR = 1;
    check_equal("BRR-is-locked", USART2->BRR, DIVIDER);
}

static void times(void)
{
    open(0, 0, 0);
    uint32_t start = DWT->CYCCNT;
    USART2->TDR = 0x5A;
    USART2->TDR = 0xA5;
    check_equal("neither-TXE-nor-TC", flags() & (ISR_TXE | ISR_TC), 0);
    while (!(USART2->ISR & ISR_RXNE)) {
    }
    uint32_t first = DWT->CYCCNT - start;
    uint32_t word = USART2->RDR;
    while (!(USART2->ISR & ISR_TC)) {
    }
    uint32_t both = DWT->CYCCNT - start;
    check_equal("first-word", word, 0x5A);
    check_equal("second-word", USART2->RDR, 0xA5);
    check_range("middle-of-the-stop-bit", first, 9 * BIT + BIT / 2, 10 * BIT);
    check_range("twenty-bits", both, 20 * BIT - BIT / 8, 20 * BIT + BIT / 8);
    check_equal("not-busy", USART2->ISR & ISR_BUSY, 0);
    RCC_DCKCFGR2 = RCC_DCKCFGR2_USART2_HSI;
    USART2->CR1 = 0;
    USART2->BRR = 139; // 16 MHz / 139
    USART2->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE;
    wait_cycles(14 * BIT);
    start = DWT->CYCCNT;
    send(0);
    check_range("by-hsi", DWT->CYCCNT - start, 18765 - 100, 18765 + 200);
    RCC_DCKCFGR2 = 0;
}

static void formats(void)
{
    open(CR1_M0, 0, 0);
    check_equal("nine-bits", loop(0x1A5), 0x1A5);
    open(CR1_M1, 0, 0);
    check_equal("seven-bits", loop(0x1A5), 0x25);
    open(CR1_PCE, 0, 0);
    check_equal("even-parity", loop(0x07), 0x87);
    open(CR1_PCE | CR1_PS, 0, 0);
    check_equal("odd-parity", loop(0x07), 0x07);
    check_equal("no-parity-error", flags() & ISR_PE, 0);
    open(0, CR2_MSBFIRST, 0);
    check_equal("msb-first", loop(0x13), 0x13);
    open(0, CR2_DATAINV, 0);
    check_equal("inverse-data", loop(0x13), 0x13);
    open(0, CR2_TXINV | CR2_RXINV, 0);
    check_equal("inverse-levels", loop(0x13), 0x13);
    USART2->CR1 = 0;
    USART2->CR3 = 0;
    USART2->CR1 = USART_CR1_UE | USART_CR1_TE;
    check_equal("idle-is-low", pin_read('D', TX), 0);
    USART2->CR1 = 0;
    USART2->CR2 = 0;
    USART2->CR1 = USART_CR1_UE | USART_CR1_TE;
    check_equal("idle-is-high", pin_read('D', TX), 1);
    open(0, 0, CR3_ONEBIT);
    check_equal("one-sample", loop(0x13), 0x13);
    USART2->CR1 = 0;
    USART2->CR1 = CR1_OVER8;
    USART2->BRR = (2 * DIVIDER & 0xFFF0) | (2 * DIVIDER & 0xF) >> 1;
    USART2->CR1 = CR1_OVER8 | USART_CR1_UE | USART_CR1_TE | USART_CR1_RE;
    wait_cycles(14 * BIT);
    uint32_t start = DWT->CYCCNT;
    uint32_t word = loop(0x13);
    check_range("over8-is-as-fast", DWT->CYCCNT - start, 11 * BIT - BIT / 4, 11 * BIT + BIT / 2);
    check_equal("over8", word, 0x13);
}

static void errors(void)
{
    open(0, 0, 0);
    send(1);
    send(2);
    wait_cycles(BIT);
    check_equal("overrun", flags() & (ISR_ORE | ISR_RXNE), ISR_ORE | ISR_RXNE);
    check_equal("the-first-stays", USART2->RDR, 1);
    check_equal("ORE-stays", flags() & (ISR_ORE | ISR_RXNE), ISR_ORE);
    USART2->ICR = ISR_ORE;
    check_equal("ORE-cleared", flags() & ISR_ORE, 0);
    open(0, 0, CR3_OVRDIS);
    send(1);
    send(2);
    wait_cycles(BIT);
    check_equal("no-overrun", flags() & ISR_ORE, 0);
    check_equal("the-newest-stays", USART2->RDR, 2);
    open(0, 0, 0);
    USART2->RQR = RQR_SBKRQ;
    check("SBKF", USART2->ISR & ISR_SBKF);
    wait_cycles(12 * BIT);
    check_equal("break-sent", USART2->ISR & ISR_SBKF, 0);
    check_equal("framing-error", flags() & (ISR_FE | ISR_RXNE), ISR_FE | ISR_RXNE);
    USART2->RQR = RQR_RXFRQ;
    check_equal("thrown-away", flags() & ISR_RXNE, 0);
    USART2->CR1 = 0;
    check_equal("flags-after-UE", USART2->ISR & 0xFFFFFBFFu, ISR_TC | ISR_TXE);
}

static void quiet(void)
{
    open(0, CR2_RTOEN | CR2_ADD('\n'), 0);
    USART2->RTOR = 5;
    loop('a');
    check_equal("no-match", USART2->ISR & ISR_CMF, 0);
    wait_cycles(2 * BIT);
    check_equal("no-timeout-yet", USART2->ISR & ISR_RTOF, 0);
    wait_cycles(4 * BIT);
    check("timeout", USART2->ISR & ISR_RTOF);
    check_equal("no-idle-yet", flags() & ISR_IDLE, 0);
    wait_cycles(6 * BIT);
    check("idle", flags() & ISR_IDLE);
    loop('\n');
    check("match", USART2->ISR & ISR_CMF);
    USART2->ICR = ISR_CMF | ISR_RTOF | ISR_IDLE;
    check_equal("cleared", USART2->ISR & (ISR_CMF | ISR_RTOF | ISR_IDLE), 0);
    open(CR1_MME, 0, 0);
    USART2->RQR = RQR_MMRQ;
    check("RWU", USART2->ISR & ISR_RWU);
    send(1);
    wait_cycles(BIT);
    check_equal("muted", flags() & ISR_RXNE, 0);
    wait_cycles(12 * BIT);
    check_equal("woken-by-idle", USART2->ISR & ISR_RWU, 0);
    check_equal("heard-again", loop(2), 2);
    open(CR1_MME | CR1_WAKE, CR2_ADD(5), 0);
    send(0x86);
    wait_cycles(BIT);
    check_equal("another-address", USART2->ISR & (ISR_RWU | ISR_RXNE), ISR_RWU);
    send(0x85);
    wait_cycles(BIT);
    check_equal("my-address", USART2->ISR & (ISR_RWU | ISR_RXNE), ISR_RXNE);
}

static void interrupts(void)
{
    open(0, 0, 0);
    forget(USART2_IRQ);
    USART2->CR1 |= USART_CR1_RXNEIE;
    DSB();
    check_equal("nothing-to-tell", pending(USART2_IRQ), 0);
    send(1);
    wait_cycles(BIT);
    check_equal("RXNE-asks", pending(USART2_IRQ), 1);
    (void)USART2->RDR;
    forget(USART2_IRQ);
    check_equal("and-no-more", pending(USART2_IRQ), 0);
    USART2->CR1 |= CR1_TCIE;
    DSB();
    check_equal("TC-asks", pending(USART2_IRQ), 1);
    USART2->ICR = ISR_TC;
    forget(USART2_IRQ);
    check_equal("until-cleared", pending(USART2_IRQ), 0);
}

int main(void)
{
    cycles_start();
    clock_start();
    RCC->AHB1ENR |= RCC_AHB1_GPIO('D');
    RCC->APB1ENR |= RCC_APB1_USART2;
    GPIO('D')->OTYPER |= 1u << TX; // one wire is open-drain, with a pull-up
    GPIO('D')->PUPDR |= 1u << 2 * TX;
    pin_alternate('D', TX, AF_USART2);
    after_reset();
    times();
    formats();
    errors();
    quiet();
    interrupts();
    check_done();
}
