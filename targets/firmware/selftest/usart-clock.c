// SPDX-License-Identifier: GPL-2.0-or-later
//
// The synchronous clock of a USART (RM0008, section 27.3.9) on USART2: TX PA2, RX PA3, CK PA4, to which nothing is attached. The
// clock is read from its own pin; what comes in is made by switching the pull of RX at its edges, as a slave would. HCLK is
// 8 MHz (HSI).

#include "check.h"
#include "chip/stm32f103.h"
#include "cycles.h"
#include "pin.h"
#include "wait.h"

#define TX 2
#define RX 3
#define CK 4

#define BIT 2000u // cycles: 4000 baud
#define LATE 160u // cycles that a polling loop and a few instructions may take

#define LBCL (1u << 8)
#define CPHA (1u << 9)
#define CPOL (1u << 10)
#define CLKEN (1u << 11)
#define BOTH (USART_CR1_UE | USART_CR1_TE | USART_CR1_RE)

static void open(uint32_t cr1, uint32_t cr2)
{
    USART2->CR1 = 0;
    RCC->APB1RSTR = RCC_APB1_USART2;
    RCC->APB1RSTR = 0;
    USART2->BRR = BIT;
    USART2->CR2 = CLKEN | cr2;
    USART2->CR1 = BOTH | cr1;
    wait_cycles(14 * BIT); // the idle frame that TE begins with
    (void)USART2->SR;
    (void)USART2->DR;
}

static bool level(void) { return pin_read(GPIOA, CK); }

// Edges of CK until TC, and when the first of them came.
static unsigned edges(uint32_t word, uint32_t *first)
{
    unsigned count = 0;
    bool before = level();
    USART2->DR = word;
    uint32_t begin = cycles();
    while (!(USART2->SR & USART_SR_TC) && cycles() - begin < 20 * BIT) {
        if (level() == before)
            continue;
        before = !before;
        if (!count++)
            *first = cycles() - begin;
    }
    return count;
}

static void pulses(void)
{
    uint32_t first = 0, second = 0;
    open(0, 0);
    check("idle-is-low", !level());
    check_equal("seven-pulses-without-lbcl", edges(0x55, &first), 14);
    open(0, LBCL);
    check_equal("eight-with-it", edges(0x55, &first), 16);
    open(USART_CR1_M, LBCL | CPHA);
    check_equal("nine-of-nine-bits", edges(0x155, &second), 18);
    // The transmitter may start at the next tick of its free-running bit clock.
    check_range("in-the-middle-of-a-bit", first, BIT + BIT / 2, 2 * BIT + BIT / 2 + LATE);
    check_range("with-cpha-at-its-beginning", second, BIT, 2 * BIT + LATE);
    open(0, CPOL);
    check("cpol-is-the-idle-level", level());
    check_equal("and-turns-pulses-over", edges(0, &first), 14);
    check("back-at-rest", level());
    USART2->CR1 = BOTH | USART_CR1_SBK;
    uint32_t begin = cycles();
    bool moved = false;
    while (cycles() - begin < 14 * BIT)
        moved |= !level();
    check("a-break-has-none", !moved);
}

// Switches RX at the edges at which a slave would, and returns what came in.
static uint32_t received(uint32_t word, uint32_t cr2)
{
    bool rises = !(cr2 & CPOL);
    open(0, LBCL | cr2);
    USART2->DR = 0xFF;
    for (unsigned bit = 0; bit < 8; ++bit) {
        // with CPHA at the first edge, without behind the second one of the bit before
        if (cr2 & CPHA || bit)
            wait_until(level() == (cr2 & CPHA ? rises : !rises));
        pin_pull(GPIOA, RX, word >> bit & 1);
        wait_until(level() == (cr2 & CPHA ? !rises : rises));
        pin_pull(GPIOA, RX, !(word >> bit & 1)); // it was sampled
    }
    return wait_until(USART2->SR & USART_SR_RXNE) ? USART2->DR : 0xDEAD;
}

static void receiving(void)
{
    static const char *const names[] = {"mode-0", "mode-1", "mode-2", "mode-3"};
    for (unsigned mode = 0; mode < 4; ++mode)
        check_equal(names[mode], received(0xA5 ^ mode << 3, (mode & 1 ? CPHA : 0) | (mode & 2 ? CPOL : 0)), 0xA5 ^ mode << 3);
    pin_pull(GPIOA, RX, true);
    open(0, LBCL);
    pin_pull(GPIOA, RX, false);
    wait_cycles(30 * BIT);
    check_equal("a-low-line-is-no-frame", USART2->SR, USART_SR_TXE | USART_SR_TC);
    USART2->DR = 0xFF;
    check("sending-receives", wait_until(USART2->SR & USART_SR_RXNE));
    check_equal("no-framing-error", USART2->SR & (USART_SR_FE | USART_SR_NE | USART_SR_ORE), 0);
    check_equal("zeros-of-a-pull-down", USART2->DR, 0);
    pin_pull(GPIOA, RX, true);
}

int main(void)
{
    cycles_start();
    RCC->APB1ENR |= RCC_APB1_USART2;
    RCC->APB2ENR |= RCC_APB2_GPIOA;
    pin_mode(GPIOA, TX, PIN_ALTERNATE);
    pin_mode(GPIOA, CK, PIN_ALTERNATE);
    pin_pull(GPIOA, RX, true);
    pulses();
    receiving();
    check_done();
}
