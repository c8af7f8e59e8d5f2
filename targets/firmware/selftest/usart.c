// SPDX-License-Identifier: GPL-2.0-or-later
//
// Serial ports (RM0008, section 27), mostly on USART2: TX PA2, RX PA3, CTS PA0, RTS PA1. Needs no wire: what USART2 sends
// is read from its own pin, and what it receives is made by switching the pull of its input pin, bit by bit. Nothing but
// that may be attached to these four pins.

#include "check.h"
#include "chip/stm32f103.h"
#include "clock.h"
#include "cycles.h"
#include "pin.h"
#include "wait.h"

#define CTS 0
#define RTS 1
#define TX 2
#define RX 3

#define DIVIDER 960u     // 37500 baud of PCLK1 = 36 MHz
#define BIT (2u * DIVIDER) // in cycles of HCLK
#define SAMPLE (BIT / 16)
#define LATE 120u        // cycles that a polling loop and a few instructions may take

#define ERRORS (USART_SR_PE | USART_SR_FE | USART_SR_NE | USART_SR_ORE)
#define RECEIVER (USART_CR1_UE | USART_CR1_RE)
#define TRANSMITTER (USART_CR1_UE | USART_CR1_TE)

// Both sides at rest, nothing pending; a fresh start after whatever was.
static void set_up(uint32_t cr1, uint32_t cr2, uint32_t cr3)
{
    RCC->APB1RSTR = RCC_APB1_USART2;
    RCC->APB1RSTR = 0;
    pin_pull(GPIOA, RX, true);
    pin_pull(GPIOA, CTS, false);
    pin_mode(GPIOA, TX, PIN_ALTERNATE);
    pin_mode(GPIOA, RTS, PIN_ALTERNATE);
    USART2->BRR = DIVIDER;
    USART2->CR2 = cr2;
    USART2->CR3 = cr3;
    USART2->CR1 = cr1;
    wait_cycles(13 * BIT); // the idle frame that TE begins with, and one for the receiver
    (void)USART2->SR;
    (void)USART2->DR;
    irq_unpend(USART2_IRQ);
}

// --- Sending (27.3.2)

static uint32_t cycles_until(uint32_t flag)
{
    uint32_t start = cycles();
    if (!wait_until(USART2->SR & flag))
        return 0;
    return cycles() - start;
}

// Both from the writing of DR. The transmitter may start at the next tick of its free-running bit clock.
static void frame_time(const char *name, uint32_t cr1, uint32_t cr2, uint32_t bits)
{
    set_up(TRANSMITTER | cr1, cr2, 0);
    USART2->DR = 0x155;
    check_range(name, cycles_until(USART_SR_TC), bits * BIT - LATE, (bits + 1) * BIT + LATE);
}

static void sending_flags(void)
{
    check_equal("sr-reset", USART2->SR, USART_SR_TXE | USART_SR_TC);
    set_up(TRANSMITTER, 0, 0);
    check_equal("txe-and-tc-at-rest", USART2->SR & (USART_SR_TXE | USART_SR_TC), USART_SR_TXE | USART_SR_TC);
    (void)USART2->SR;
    USART2->DR = 0x55;
    check_equal("tc-cleared-by-sr-then-dr", USART2->SR & USART_SR_TC, 0);
    wait_cycles(12 * BIT);

    set_up(TRANSMITTER, 0, 0);
    (void)USART2->SR;
    USART2->DR = 0x55;
    uint32_t first = cycles_until(USART_SR_TXE);
    USART2->DR = 0xAA;
    uint32_t taken = USART2->SR & USART_SR_TXE;
    wait_until(USART2->SR & USART_SR_TXE);
    uint32_t second = cycles();
    USART2->DR = 0x00;
    wait_until(USART2->SR & USART_SR_TXE);
    uint32_t third = cycles();
    uint32_t early = USART2->SR & USART_SR_TC;
    uint32_t last = cycles_until(USART_SR_TC);
    check_range("txe-at-once-when-idle", first, 0, BIT + LATE);
    check_equal("txe-falls-while-sending", taken, 0);
    check_range("frames-follow-without-gap", third - second, 10 * BIT - LATE, 10 * BIT + LATE);
    check_equal("tc-waits-for-the-last", early, 0);
    check_range("tc-after-the-last", last, 10 * BIT - 2 * LATE, 10 * BIT + LATE);
    USART2->SR = ~USART_SR_TC;
    check_equal("tc-cleared-by-0", USART2->SR & USART_SR_TC, 0);
    USART2->SR = ~0u;
    check_equal("txe-is-not-writable", USART2->SR & USART_SR_TXE, USART_SR_TXE);
}

static void sending_rules(void)
{
    // Only what a read of SR has seen is cleared by the write of DR after it (27.6.1)
    set_up(TRANSMITTER, 0, 0);
    USART2->DR = 0x55;
    wait_cycles(12 * BIT);
    USART2->DR = 0xAA;
    check_equal("tc-stays-without-reading-sr", USART2->SR & USART_SR_TC, USART_SR_TC);
    wait_cycles(12 * BIT);

    set_up(USART_CR1_UE, 0, 0);
    USART2->CR1 = TRANSMITTER;
    USART2->DR = 0x55;
    uint32_t start = cycles();
    bool begun = wait_until(!pin_read(GPIOA, TX));
    uint32_t idle = cycles() - start;
    check("sends-once-te-is-set", begun);
    check_range("te-begins-with-an-idle-frame", idle, 10 * BIT - LATE, 11 * BIT + LATE);
}

static void sending_times(void)
{
    frame_time("8-bits-1-stop", 0, 0, 10);
    frame_time("8-bits-2-stop", 0, USART_CR2_STOP_2, 11);
    frame_time("9-bits-1-stop", USART_CR1_M, 0, 11);
    frame_time("9-bits-2-stop", USART_CR1_M, USART_CR2_STOP_2, 12);
    frame_time("7-bits-parity", USART_CR1_PCE, 0, 10);
}

// What stands on the TX pin, the start bit lowest, sampled in the middle of each bit.
static uint32_t sent_frame(uint32_t cr1, uint32_t cr2, uint32_t data, uint32_t bits)
{
    set_up(TRANSMITTER | cr1, cr2, 0);
    USART2->DR = data;
    if (!wait_until(!pin_read(GPIOA, TX)))
        return 0xFFFFFFFF;
    uint32_t at = cycles() + BIT / 2 - BIT, frame = 0;
    for (uint32_t bit = 0; bit < bits; ++bit) {
        at = wait_cycles_from(at, BIT);
        frame |= (uint32_t)pin_read(GPIOA, TX) << bit;
    }
    return frame;
}

static void sending_shapes(void)
{
    set_up(TRANSMITTER, 0, 0);
    check("line-rests-high", pin_read(GPIOA, TX));
    check_equal("sends-c3", sent_frame(0, 0, 0xC3, 10), 0x200 | 0xC3 << 1);
    check_equal("sends-9-bits", sent_frame(USART_CR1_M, 0, 0x135, 11), 0x400 | 0x135 << 1);
    check_equal("sends-even-parity", sent_frame(USART_CR1_M | USART_CR1_PCE, 0, 0x57, 11), 0x400 | 0x157 << 1);
    check_equal("sends-odd-parity", sent_frame(USART_CR1_M | USART_CR1_PCE | USART_CR1_PS, 0, 0x57, 11), 0x400 | 0x57 << 1);
    check_equal("parity-replaces-bit-7", sent_frame(USART_CR1_PCE, 0, 0x81, 10), 0x200 | 0x81 << 1);
    check_equal("sends-2-stop-bits", sent_frame(0, USART_CR2_STOP_2, 0x00, 11), 0x600);
}

static void sending_break(void)
{
    set_up(TRANSMITTER, 0, 0);
    USART2->CR1 |= USART_CR1_SBK;
    bool begins = wait_until(!pin_read(GPIOA, TX));
    uint32_t start = cycles();
    bool ends = wait_until(pin_read(GPIOA, TX));
    uint32_t length = cycles() - start;
    check("break-begins", begins);
    check("break-ends", ends);
    check_range("break-is-10-bits", length, 10 * BIT - LATE, 10 * BIT + LATE);
    wait_cycles(2 * BIT);
    check_equal("sbk-clears-itself", USART2->CR1 & USART_CR1_SBK, 0);
}

static void each_port(const char *name, volatile usart_t *usart, uint32_t bit)
{
    usart->BRR = 625;
    usart->CR1 = TRANSMITTER;
    wait_cycles(12 * bit);
    (void)usart->SR;
    usart->DR = 'x';
    while (!(usart->SR & USART_SR_TXE)) {
    }
    usart->DR = 'y';
    wait_until(usart->SR & USART_SR_TXE);
    uint32_t start = cycles();
    wait_until(usart->SR & USART_SR_TC);
    check_range(name, cycles() - start, 10 * bit - LATE, 10 * bit + LATE);
    usart->CR1 = 0;
}

// --- Receiving (27.3.3)

// Sends `count` bits, the lowest first, by the pull of `pin`, and leaves the line as the last of them.
static void wiggle(unsigned pin, uint32_t bits, uint32_t count, uint32_t bit_cycles)
{
    uint32_t at = cycles();
    for (; count; --count, bits >>= 1) {
        pin_write(GPIOA, pin, bits & 1);
        at = wait_cycles_from(at, bit_cycles);
    }
}

static void receive_8(uint32_t data) { wiggle(RX, 0x200 | (data & 0xFF) << 1, 10, BIT); }
static void receive_9(uint32_t data) { wiggle(RX, 0x400 | (data & 0x1FF) << 1, 11, BIT); }

static void expect_received(const char *name, uint32_t flags, uint32_t data)
{
    uint32_t status = USART2->SR & (ERRORS | USART_SR_RXNE);
    uint32_t got = USART2->DR;
    if (status != flags)
        check_equal(name, status, flags);
    else
        check_equal(name, got, data);
}

static void receiving_data(void)
{
    set_up(RECEIVER, 0, 0);
    check_equal("nothing-received", USART2->SR & (ERRORS | USART_SR_RXNE), 0);
    receive_8(0xA5);
    expect_received("receives-a5", USART_SR_RXNE, 0xA5);
    check_equal("rxne-cleared-by-dr", USART2->SR & USART_SR_RXNE, 0);
    receive_8(0x00);
    expect_received("receives-00", USART_SR_RXNE, 0x00);
    receive_8(0xFF);
    expect_received("receives-ff", USART_SR_RXNE, 0xFF);
    receive_8(0x12);
    USART2->SR = ~USART_SR_RXNE;
    check_equal("rxne-cleared-by-0", USART2->SR & USART_SR_RXNE, 0);

    wiggle(RX, 0x0C3 << 1, 9, BIT);
    check_equal("not-received-before-stop-bit", USART2->SR & USART_SR_RXNE, 0);
    pin_write(GPIOA, RX, true);
    wait_cycles(BIT);
    expect_received("received-within-stop-bit", USART_SR_RXNE, 0xC3);

    wiggle(RX, 0x200 | 0x69 << 1, 10, BIT - BIT / 40);
    wait_cycles(BIT);
    expect_received("receives-2.5-percent-fast", USART_SR_RXNE, 0x69);
    wiggle(RX, 0x200 | 0x96 << 1, 10, BIT + BIT / 40);
    wait_cycles(BIT);
    expect_received("receives-2.5-percent-slow", USART_SR_RXNE, 0x96);

    set_up(RECEIVER | USART_CR1_M, 0, 0);
    receive_9(0x1A5);
    expect_received("receives-9-bits", USART_SR_RXNE, 0x1A5);
}

static void receiving_errors(void)
{
    set_up(RECEIVER, 0, 0);
    receive_8(0x11);
    receive_8(0x22);
    expect_received("overrun-keeps-first", USART_SR_RXNE | USART_SR_ORE, 0x11);
    check_equal("overrun-cleared-by-sr-then-dr", USART2->SR & (ERRORS | USART_SR_RXNE), 0);
    receive_8(0x33);
    expect_received("receives-after-overrun", USART_SR_RXNE, 0x33);
    receive_8(0x44);
    receive_8(0x55);
    (void)USART2->DR; // nobody has read of the overrun
    check_equal("overrun-stays-without-reading-sr", USART2->SR & (ERRORS | USART_SR_RXNE), USART_SR_ORE);
    (void)USART2->DR;

    wiggle(RX, 0x5A << 1, 10, BIT); // the stop bit is low
    pin_write(GPIOA, RX, true);
    expect_received("framing-error", USART_SR_RXNE | USART_SR_FE, 0x5A);
    check_equal("framing-error-cleared", USART2->SR & ERRORS, 0);
    wait_cycles(2 * BIT);
    pin_write(GPIOA, RX, false);
    wait_cycles(25 * BIT);
    expect_received("break-is-a-framing-error", USART_SR_RXNE | USART_SR_FE, 0);
    check_equal("break-is-received-once", USART2->SR & (ERRORS | USART_SR_RXNE), 0);
    pin_write(GPIOA, RX, true);
    wait_cycles(2 * BIT);

    set_up(RECEIVER | USART_CR1_M | USART_CR1_PCE, 0, 0);
    receive_9(0x157);
    expect_received("even-parity-is-right", USART_SR_RXNE, 0x157);
    receive_9(0x057);
    expect_received("even-parity-is-wrong", USART_SR_RXNE | USART_SR_PE, 0x057);
    check_equal("parity-error-cleared", USART2->SR & ERRORS, 0);
    set_up(RECEIVER | USART_CR1_PCE | USART_CR1_PS, 0, 0);
    receive_8(0x80);
    expect_received("odd-parity-is-right", USART_SR_RXNE, 0x80);
    receive_8(0x00);
    expect_received("odd-parity-is-wrong", USART_SR_RXNE | USART_SR_PE, 0x00);
}

static void receiving_noise(void)
{
    set_up(RECEIVER, 0, 0);
    wiggle(RX, 0, 1, 4 * SAMPLE);
    pin_write(GPIOA, RX, true);
    wait_cycles(12 * BIT);
    check_equal("short-start-bit-is-none", USART2->SR & (ERRORS | USART_SR_RXNE), 0);

    // Samples 8, 9 and 10 of 16 decide by majority; here one of the three in the fourth data bit is low
    wiggle(RX, 0x7 << 1, 4, BIT);
    uint32_t at = cycles();
    pin_write(GPIOA, RX, true);
    at = wait_cycles_from(at, 8 * SAMPLE);
    pin_write(GPIOA, RX, false);
    at = wait_cycles_from(at, SAMPLE);
    pin_write(GPIOA, RX, true);
    wait_cycles_from(at, 7 * SAMPLE);
    wiggle(RX, 0x10, 5, BIT);
    expect_received("noise-is-noticed", USART_SR_RXNE | USART_SR_NE, 0x0F);
}

static void idle_line(void)
{
    set_up(RECEIVER, 0, 0);
    receive_8(0x42);
    uint32_t early = USART2->SR & USART_SR_IDLE;
    uint32_t waited = cycles_until(USART_SR_IDLE);
    check_equal("no-idle-yet", early, 0);
    check_range("idle-after-a-frame", waited, 9 * BIT, 11 * BIT + LATE);
    (void)USART2->SR;
    (void)USART2->DR;
    check_equal("idle-cleared-by-sr-then-dr", USART2->SR & USART_SR_IDLE, 0);
    wait_cycles(25 * BIT);
    check_equal("idle-only-once", USART2->SR & USART_SR_IDLE, 0);
}

// --- Interrupt conditions (27.4)

static bool requested(void)
{
    irq_unpend(USART2_IRQ); // a level: it pends again while a flag and its enable stand
    return irq_is_pending(USART2_IRQ);
}

static void interrupt_conditions(void)
{
    set_up(TRANSMITTER | USART_CR1_RE, 0, 0);
    check("no-request-without-enable", !requested());
    USART2->CR1 |= USART_CR1_TXEIE;
    check("txeie", requested());
    USART2->CR1 ^= USART_CR1_TXEIE | USART_CR1_TCIE;
    check("tcie", requested());
    USART2->SR = ~USART_SR_TC;
    check("tc-cleared-no-request", !requested());
    USART2->CR1 = TRANSMITTER | USART_CR1_RE | USART_CR1_RXNEIE;
    receive_8(1);
    check("rxneie", requested());
    (void)USART2->DR;
    check("rxne-read-no-request", !requested());
    receive_8(1);
    receive_8(2);
    USART2->SR = ~USART_SR_RXNE;
    check("rxneie-stands-for-ore", requested());
    (void)USART2->SR;
    (void)USART2->DR;
    check("ore-cleared-no-request", !requested());
    USART2->CR1 = RECEIVER | USART_CR1_IDLEIE;
    receive_8(3);
    (void)USART2->DR;
    wait_cycles(12 * BIT);
    check("idleie", requested());
    (void)USART2->SR;
    (void)USART2->DR;
    check("idle-cleared-no-request", !requested());

    USART2->CR1 = RECEIVER;
    USART2->CR3 = USART_CR3_EIE;
    wiggle(RX, 0x5A << 1, 10, BIT);
    pin_write(GPIOA, RX, true);
    check("eie-needs-dmar", !requested());
    USART2->CR3 = USART_CR3_EIE | USART_CR3_DMAR;
    check("eie-with-dmar", requested());
    set_up(RECEIVER | USART_CR1_PCE | USART_CR1_PEIE, 0, 0);
    receive_8(0x01);
    check("peie", requested());
    USART2->CR1 = 0;
}

// --- Mute mode (27.3.6)

static void mute_mode(void)
{
    set_up(RECEIVER, 0, 0);
    receive_8(0x01); // mute mode wants a byte received before it
    (void)USART2->DR;
    USART2->CR1 |= USART_CR1_RWU;
    receive_8(0x02);
    uint32_t muted = USART2->CR1 & USART_CR1_RWU;
    check_equal("mute-lasts-over-a-frame", muted, USART_CR1_RWU);
    expect_received("mute-receives-nothing", 0, 0x01);
    wait_cycles(12 * BIT);
    check_equal("idle-line-wakes", USART2->CR1 & USART_CR1_RWU, 0);
    receive_8(0x03);
    expect_received("receives-after-waking", USART_SR_RXNE, 0x03);

    set_up(RECEIVER | USART_CR1_WAKE, 3, 0);
    receive_8(0x83);
    (void)USART2->DR;
    USART2->CR1 |= USART_CR1_RWU;
    receive_8(0x03);
    check_equal("data-does-not-wake", USART2->SR & USART_SR_RXNE, 0);
    receive_8(0x84);
    check_equal("other-address-does-not-wake", USART2->SR & USART_SR_RXNE, 0);
    receive_8(0x83);
    expect_received("own-address-wakes", USART_SR_RXNE, 0x83);
    receive_8(0x21);
    expect_received("receives-after-own-address", USART_SR_RXNE, 0x21);
    receive_8(0x85);
    check_equal("other-address-mutes-again", USART2->CR1 & USART_CR1_RWU, USART_CR1_RWU);
}

// --- LIN break detection (27.3.8)

static void lin(void)
{
    set_up(RECEIVER, USART_CR2_LINEN | USART_CR2_LBDL, 0);
    wiggle(RX, 0, 10, BIT);
    pin_write(GPIOA, RX, true);
    wait_cycles(2 * BIT);
    check_equal("10-bits-are-too-short", USART2->SR & USART_SR_LBD, 0);
    wait_cycles(12 * BIT);
    wiggle(RX, 0, 13, BIT);
    pin_write(GPIOA, RX, true);
    wait_cycles(2 * BIT);
    check_equal("break-detected", USART2->SR & USART_SR_LBD, USART_SR_LBD);
    USART2->SR = ~USART_SR_LBD;
    check_equal("lbd-cleared-by-0", USART2->SR & USART_SR_LBD, 0);
}

// --- Flow control (27.3.13)

static void flow_control(void)
{
    set_up(TRANSMITTER, 0, USART_CR3_CTSE);
    USART2->SR = ~USART_SR_CTS;
    pin_write(GPIOA, CTS, true);
    wait_cycles(BIT);
    check_equal("cts-flag-on-change", USART2->SR & USART_SR_CTS, USART_SR_CTS);
    USART2->SR = ~USART_SR_CTS;
    check_equal("cts-cleared-by-0", USART2->SR & USART_SR_CTS, 0);
    (void)USART2->SR;
    USART2->DR = 0x55;
    wait_cycles(15 * BIT);
    check_equal("cts-high-holds", USART2->SR & USART_SR_TC, 0);
    check("held-line-rests", pin_read(GPIOA, TX));
    pin_write(GPIOA, CTS, false);
    check_range("cts-low-sends", cycles_until(USART_SR_TC), 10 * BIT - LATE, 11 * BIT + LATE);

    set_up(RECEIVER, 0, USART_CR3_RTSE);
    check("rts-low-when-empty", !pin_read(GPIOA, RTS));
    receive_8(0x77);
    check("rts-high-when-full", pin_read(GPIOA, RTS));
    (void)USART2->DR;
    NOP();
    check("rts-low-when-read", !pin_read(GPIOA, RTS));
}

// --- Half duplex (27.3.10): the receiver listens to the TX pin and no longer to RX

static void half_duplex(void)
{
    set_up(RECEIVER, 0, USART_CR3_HDSEL);
    pin_pull(GPIOA, TX, true);
    wait_cycles(2 * BIT);
    (void)USART2->SR;
    (void)USART2->DR;
    wiggle(TX, 0x200 | 0x3C << 1, 10, BIT);
    expect_received("half-duplex-listens-to-tx", USART_SR_RXNE, 0x3C);
    receive_8(0x18);
    check_equal("half-duplex-is-deaf-to-rx", USART2->SR & USART_SR_RXNE, 0);
    set_up(RECEIVER | USART_CR1_TE, 0, USART_CR3_HDSEL);
    USART2->DR = 0x3C;
    wait_cycles(12 * BIT);
    expect_received("half-duplex-hears-itself", USART_SR_RXNE, 0x3C);
}

int main(void)
{
    clock_72mhz();
    cycles_start();
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_AFIO | RCC_APB2_USART1;
    RCC->APB1ENR |= RCC_APB1_USART2 | RCC_APB1_USART3;
    sending_flags();
    sending_rules();
    sending_times();
    sending_shapes();
    sending_break();
    receiving_data();
    receiving_errors();
    receiving_noise();
    idle_line();
    interrupt_conditions();
    mute_mode();
    lin();
    flow_control();
    half_duplex();
    each_port("usart1-at-115200", USART1, 625);
    each_port("usart2-at-57600", USART2, 1250);
    each_port("usart3-at-57600", USART3, 1250);
    check_done();
}
