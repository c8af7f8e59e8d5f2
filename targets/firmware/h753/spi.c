// SPDX-License-Identifier: GPL-2.0-or-later
//
// SPI1 with its packets and transfers (RM0433, section 50) as a master to which nothing is attached: what it receives is what
// the pull of PA6 (MISO) says. PA4 to PA7 must be free. Its clock is HSI, at 64 MHz.

#include "h753/spi.h"

#include "check.h"
#include "h753/clock.h"
#include "wait.h"

#define CLOCK(mbr) (CPU_HZ / 32000000u << (mbr)) // of SCK, in cycles: 15 at least
#define BYTES (DSIZE(8) | CRCSIZE(8))

static void pull(unsigned pin, bool up) { GPIO('A')->PUPDR = (GPIO('A')->PUPDR & ~(3u << 2 * pin)) | (up ? 1u : 2u) << 2 * pin; }

// Sections 50.4.9 and 50.4.10.
static void open(uint32_t cfg1, uint32_t cfg2, uint32_t size, uint32_t cr1)
{
    SPI1->CR1 = 0;
    SPI1->IFCR = CLEAR_ALL;
    SPI1->IER = 0;
    SPI1->CR1 = SSI | cr1;
    SPI1->CFG1 = cfg1;
    SPI1->CFG2 = cfg2 | MASTER | (cfg2 & SSOE ? 0 : SSM);
    SPI1->CR2 = size;
    SPI1->CR1 |= SPE;
}

static void start(void) { SPI1->CR1 |= CSTART; }

static uint32_t flags(void) { return SPI1->SR & FLAGS; }

// --- Words and transfers (50.4.11)

static void transfers(void)
{
    check_equal("SR", SPI1->SR, TXP | TXC);
    check_equal("CFG1", SPI1->CFG1, BYTES);
    check_equal("CRCPOLY", SPI1->CRCPOLY, 0x107);
    pull(MISO, true);
    uint32_t wrong = 0, slow = 0;
    for (unsigned bits = 4; bits <= 32; ++bits) {
        open(DSIZE(bits) | CRCSIZE(8) | MBR(3), 0, 1, 0);
        SPI1->TXDR = 0x5A5A5A5A;
        start();
        uint32_t begun = DWT->CYCCNT;
        wait_until(SPI1->SR & EOT);
        uint32_t took = DWT->CYCCNT - begun;
        wrong += SPI1->RXDR != 0xFFFFFFFFu >> (32 - bits);
        slow += took < bits * CLOCK(3) - 200 || took > bits * CLOCK(3) + 200;
    }
    check_equal("ones-of-a-pull-up-of-each-length", wrong, 0);
    check_equal("a-clock-for-each-bit", slow, 0);

    pull(MISO, false);
    open(BYTES | MBR(6), 0, 2, 0);
    check_equal("TSIZE", SPI1->SR, TXP | 2u << 16);
    SPI1_TXDR8 = 0xFE;
    check_equal("one-of-two-is-not-all", flags(), TXP);
    SPI1_TXDR8 = 0xFE;
    check_equal("TXTF", flags(), TXP | TXTF);
    wait_cycles(20 * CLOCK(6));
    check_equal("nothing-goes-before-CSTART", SPI1->SR >> 16, 2);
    start();
    wait_cycles(12 * CLOCK(6));
    check_equal("CTSIZE", SPI1->SR >> 16, 1);
    wait_until(SPI1->SR & EOT);
    check_equal("EOT", flags(), TXP | RXP | DXP | EOT | TXTF | TXC);
    check_equal("two-are-there", SPI1->SR & ~(uint32_t)FLAGS, RXPLVL(2));
    check_equal("CSTART-is-over", SPI1->CR1, SPE | SSI);
    check_equal("one-access-takes-both", SPI1_RXDR16 | (SPI1->SR & RXP), 0);
    SPI1->IFCR = EOT | TXTF;
    check_equal("IFCR", flags(), TXP);
    SPI1->CFG1 = 0;
    check_equal("CFG1-is-locked", SPI1->CFG1, BYTES | MBR(6));
    check("MOSI-keeps-the-last-bit", !pin_read('A', MOSI));
    open(BYTES, LSBFRST | CPOL | AFCNTR, 1, 0);
    check("CPOL-is-the-idle-level", pin_read('A', SCK));
    SPI1_TXDR8 = 0xFE;
    start();
    wait_until(SPI1->SR & EOT);
    check("LSBFRST", pin_read('A', MOSI));
    SPI1->CR1 = 0;
    check("AFCNTR-keeps-the-pins", pin_read('A', SCK));

    open(BYTES, SIMPLEX_TX, 0, 0);
    check_equal("endless-and-idle", flags(), TXP | TXC);
    start();
    SPI1_TXDR8 = 1;
    check_equal("endless-and-busy", flags(), TXP);
    check("TXC-again", wait_until(SPI1->SR & TXC));
    check_equal("CSTART-stays", SPI1->CR1 & CSTART, CSTART);
    check_equal("nothing-is-received", SPI1->SR & RXP, 0);

    open(BYTES | MBR(4), SIMPLEX_TX, 1, 0);
    SPI1->CR2 |= 2u << 16;
    SPI1_TXDR16 = 0;
    SPI1_TXDR8 = 0;
    start();
    wait_cycles(12 * CLOCK(4));
    uint32_t between = SPI1->SR, left = SPI1->CR2;
    check("extended-by-TSER", wait_until(SPI1->SR & EOT));
    check_equal("TSERF", between & (TSERF | EOT), TSERF);
    check_equal("TSER-is-used", left, 1);
}

// --- Packets (50.4.13)

static void packets(void)
{
    open(BYTES | FTHLV(8), 0, 0, 0);
    for (unsigned word = 0; word < 8; ++word)
        SPI1_TXDR8 = 0;
    check_equal("room-for-another-packet", flags() & TXP, TXP);
    SPI1_TXDR8 = 0;
    check_equal("and-for-none", flags() & TXP, 0);
    open(BYTES | FTHLV(4), 0, 7, 0);
    SPI1->TXDR = 0;
    SPI1->TXDR = 0;
    start();
    wait_until(SPI1->SR & EOT);
    check_equal("a-packet-and-three", SPI1->SR & (RXWNE | RXPLVL(3) | RXP), RXWNE | RXPLVL(3) | RXP);
    (void)SPI1->RXDR;
    check_equal("three-are-no-packet", SPI1->SR & (RXWNE | RXPLVL(3) | RXP), RXPLVL(3));
    (void)SPI1_RXDR16;
    (void)SPI1_RXDR8;
    check_equal("and-then-none", SPI1->SR & (RXWNE | RXPLVL(3) | RXP), 0);
}

// --- Suspension, overrun, mode fault (50.4.11, 50.5.2)

static void errors(void)
{
    open(BYTES | MBR(5), SIMPLEX_RX, 0, 0);
    start();
    wait_cycles(4 * CLOCK(5));
    SPI1->CR1 |= CSUSP;
    uint32_t at_once = SPI1->SR & SUSP;
    wait_cycles(12 * CLOCK(5));
    check_equal("the-word-ends-first", at_once, 0);
    check_equal("suspended", SPI1->SR & SUSP, SUSP);
    check_equal("and-CSTART-falls", SPI1->CR1 & CSTART, 0);
    check_equal("after-one-word", SPI1->SR & (RXWNE | RXPLVL(3)), RXPLVL(1));

    open(BYTES, SIMPLEX_RX, 20, MASRX);
    start();
    wait_until(SPI1->SR & SUSP);
    uint32_t left = SPI1->SR >> 16;
    for (unsigned word = 0; word < 4; ++word)
        (void)SPI1->RXDR;
    SPI1->IFCR = SUSP;
    check_equal("MASRX-waits-for-room", left, 4);
    check("and-goes-on", wait_until(SPI1->SR & EOT));
    check_equal("without-an-overrun", SPI1->SR & OVR, 0);
    open(BYTES, SIMPLEX_RX, 20, 0);
    start();
    wait_until(SPI1->SR & EOT);
    check_equal("which-there-is-without", SPI1->SR & OVR, OVR);
    SPI1->IFCR = OVR;
    check_equal("OVRC", SPI1->SR & OVR, 0);

    SPI1->CR1 = SPE;
    check_equal("mode-fault-by-SSI", SPI1->CR1 & SPE, 0);
    check_equal("no-master", SPI1->CFG2 & MASTER, 0);
    SPI1->CR1 = SPE | SSI;
    check_equal("MODF-holds-SPE", SPI1->CR1 & SPE, 0);
    SPI1->IFCR = MODF;
    check_equal("MODFC", SPI1->SR & MODF, 0);
}

// --- SS (50.4.7)

static void slave_select(void)
{
    pin_alternate('A', NSS, AF_SPI1);
    open(BYTES | MBR(6), SSOE | SSOM | MSSI(4) | MIDI(4), 2, 0);
    bool before = pin_read('A', NSS);
    SPI1_TXDR16 = 0;
    uint32_t begun = DWT->CYCCNT;
    start();
    bool within = pin_read('A', NSS);
    wait_cycles(14 * CLOCK(6));
    bool between = pin_read('A', NSS);
    wait_until(SPI1->SR & EOT);
    uint32_t took = DWT->CYCCNT - begun;
    check("active-from-the-start", before && !within);
    check("not-between-two-words", between);
    check_range("with-pauses", took, 24 * CLOCK(6) - 300, 24 * CLOCK(6) + 300);
    check("nor-after-the-end", pin_read('A', NSS));
    open(BYTES, SSOE | SSIOP, 1, 0);
    check("SSIOP", !pin_read('A', NSS));
    pin_mode('A', NSS, PIN_INPUT);
}

// --- CRC (50.5.3)

static void crc(void)
{
    pull(MISO, true);
    open(DSIZE(8) | CRCSIZE(8) | CRCEN, 0, 2, 0);
    SPI1_TXDR16 = '1' | '2' << 8;
    start();
    wait_until(SPI1->SR & EOT);
    check_equal("tx-crc", SPI1->TXCRC, 0x72);
    check_equal("rx-crc-of-two-FF", SPI1->RXCRC, 0x24);
    check_equal("what-came-in-is-none", SPI1->SR & CRCE, CRCE);
    check_equal("and-is-not-kept", SPI1->SR & (RXWNE | RXPLVL(3)), RXPLVL(2));
    SPI1->CR1 = 0;
    SPI1->CRCPOLY = 0x11021;
    open(DSIZE(8) | CRCSIZE(16) | CRCEN | MBR(5), SIMPLEX_TX, 9, TCRCINI);
    static const char text[] = "123456789";
    for (unsigned at = 0; at < 9; ++at)
        SPI1_TXDR8 = (uint8_t)text[at];
    uint32_t begun = DWT->CYCCNT;
    start();
    wait_until(SPI1->SR & EOT);
    uint32_t took = DWT->CYCCNT - begun;
    check_equal("crc-of-16-bits-from-ones", SPI1->TXCRC, 0x29B1);
    check_range("goes-as-two-words-of-8", took, 88 * CLOCK(5) - 300, 88 * CLOCK(5) + 300);
    SPI1->CR1 = 0;
    SPI1->CRCPOLY = 0x107;
}

// --- Interrupts, DMA (50.4.14)

static bool pending(void) { return NVIC->ISPR[SPI1_IRQ / 32] >> SPI1_IRQ % 32 & 1u; }

static void forget(void)
{
    NVIC->ICPR[SPI1_IRQ / 32] = 1u << SPI1_IRQ % 32;
    DSB();
}

static void lines(void)
{
    open(BYTES, 0, 1, 0);
    forget();
    SPI1->IER = EOT | RXP;
    check("none-without-a-word", !pending());
    SPI1->IER |= TXP;
    check("TXPIE", pending());
    SPI1_TXDR8 = 1;
    check_equal("TXTF-takes-it-back", SPI1->IER, EOT | RXP);
    forget();
    check("and-the-level", !pending());
    start();
    wait_until(SPI1->SR & EOT);
    check("EOTIE", pending());
    SPI1->IFCR = EOT | TXTF;
    (void)SPI1_RXDR8;
    forget();
    check("level-falls-with-the-flags", !pending());
}

#define OUT ((volatile uint8_t *)0x24000000u)
#define IN ((volatile uint8_t *)0x24000040u)

static void stream(unsigned number, uint32_t request, volatile void *port, volatile void *memory, uint32_t control)
{
    DMA1->S[number].CR = 0;
    DMAMUX1[number] = request;
    DMA1->S[number].PAR = (uint32_t)port;
    DMA1->S[number].M0AR = (uint32_t)memory;
    DMA1->S[number].NDTR = 22;
    DMA1->S[number].CR = control | DMA_MINC;
    DMA1->S[number].CR |= DMA_EN;
}

// Packets of four words, which 22 are no multiple of; in the order of the section.
static void by_dma(void)
{
    uint32_t same = 0;
    for (unsigned at = 0; at < 64; ++at)
        OUT[at] = 0x55;
    open(BYTES | FTHLV(4) | RXDMAEN | MBR(2), 0, 22, 0);
    SPI1->CR1 = SSI;
    SPI1->CFG1 = BYTES | FTHLV(4) | RXDMAEN | MBR(2);
    DMA1->LIFCR = 0x0F7D0F7D;
    stream(0, REQUEST_SPI1_RX, &SPI1->RXDR, IN, 0);
    stream(1, REQUEST_SPI1_TX, &SPI1->TXDR, OUT, DMA_TO_PERIPHERAL);
    SPI1->CFG1 |= TXDMAEN;
    SPI1->CR1 |= SPE;
    start();
    check("to-the-end", wait_until(SPI1->SR & EOT));
    check("and-all-is-received", wait_until(DMA1->LISR & DMA_TCIF));
    for (unsigned at = 0; at < 22; ++at)
        same += IN[at] == 0xFF;
    check_equal("each-word", same, 22);
    check_equal("sent", DMA1->LISR >> 6 & DMA_TCIF, DMA_TCIF);
    check_equal("none-was-lost", flags() & (OVR | RXP), 0);
}

int main(void)
{
    counter_start();
    clock_start();
    RCC->AHB1ENR |= RCC_AHB1_DMA1;
    RCC->AHB4ENR |= RCC_AHB4_GPIO('A');
    RCC->APB2ENR |= RCC_APB2_SPI1;
    RCC->D2CCIP1R = RCC_SPI123_PER;
    for (unsigned pin = SCK; pin <= MOSI; ++pin)
        pin_alternate('A', pin, AF_SPI1);
    transfers();
    packets();
    errors();
    slave_select();
    crc();
    lines();
    by_dma();
    check_done();
}
