// SPDX-License-Identifier: GPL-2.0-or-later
//
// SPI1 with its FIFOs (RM0410, section 35) as a master to which nothing is attached: what it receives is what the pull of PA6
// (MISO) says. PA4 to PA7 must be free. PCLK2 is half of HCLK.

#include "f767/spi.h"

#include "check.h"
#include "f767/clock.h"
#include "wait.h"

#define MASTER (CR1_MSTR | CR1_SSM | CR1_SSI)
#define CLOCK(br) (2u * (2u << (br))) // of SCK, in cycles of HCLK
#define SLOW CR1_BR(7)

static void pull(unsigned pin, bool up) { GPIO('A')->PUPDR = (GPIO('A')->PUPDR & ~(3u << 2 * pin)) | (up ? 1u : 2u) << 2 * pin; }

static void restart(uint32_t cr1, uint32_t cr2)
{
    RCC_APB2RSTR = RCC_APB2_SPI1;
    RCC_APB2RSTR = 0;
    SPI1->CR2 = cr2;
    SPI1->CR1 = cr1;
    SPI1->CR1 = cr1 | CR1_SPE;
}

static bool idle(void) { return wait_until(!(SPI1->SR & SR_BSY)); }

static uint32_t transfer(uint32_t word, bool wide)
{
    if (wide)
        SPI1_DR16 = (uint16_t)word;
    else
        SPI1_DR8 = (uint8_t)word;
    if (!wait_until(SPI1->SR & SR_RXNE))
        return 0xDEAD;
    return wide ? SPI1_DR16 : SPI1_DR8;
}

// --- Words of 4 to 16 bits (35.5.6, 35.9.2)

static void words(void)
{
    check_equal("SR", SPI1->SR, SR_TXE);
    check_equal("CR2", SPI1->CR2, CR2_DS(8));
    check_equal("CRCPR", SPI1->CRCPR, 7);
    SPI1->CR2 = CR2_DS(3);
    check_equal("no-words-of-3-bits", SPI1->CR2, CR2_DS(8));
    pull(MISO, true);
    uint32_t wrong = 0, slow = 0;
    for (unsigned bits = 4; bits <= 16; ++bits) {
        restart(MASTER | CR1_BR(5), CR2_DS(bits) | (bits <= 8 ? CR2_FRXTH : 0));
        uint32_t start = DWT->CYCCNT;
        uint32_t word = transfer(0x5A5A, bits > 8);
        uint32_t took = DWT->CYCCNT - start;
        wrong += word != (1u << bits) - 1;
        slow += took < bits * CLOCK(5) || took > bits * CLOCK(5) + 100;
    }
    check_equal("ones-of-a-pull-up-of-each-length", wrong, 0);
    check_equal("a-clock-for-each-bit", slow, 0);
    pull(MISO, false);
    restart(MASTER, CR2_DS(8) | CR2_FRXTH);
    check_equal("zeros-of-a-pull-down", transfer(0x5A, false), 0);
    check_equal("DR-takes-it-away", SPI1->SR, SR_TXE);
    transfer(0xFE, false);
    check("MOSI-keeps-the-last-bit", !pin_read('A', MOSI));
    restart(MASTER | CR1_LSBFIRST | CR1_CPOL, CR2_DS(8) | CR2_FRXTH);
    check("CPOL-is-the-idle-level", pin_read('A', SCK));
    transfer(0xFE, false);
    check("LSBFIRST", pin_read('A', MOSI));

    restart(MASTER | CR1_RXONLY | CR1_BR(5), CR2_DS(8) | CR2_FRXTH);
    bool first = wait_until(SPI1->SR & SR_RXNE);
    (void)SPI1_DR8;
    bool second = wait_until(SPI1->SR & SR_RXNE);
    SPI1->CR1 &= ~(uint32_t)CR1_SPE;
    (void)SPI1_DR8;
    wait_cycles(20 * CLOCK(5));
    check("receive-only-goes-on", first && second);
    check_equal("until-SPE-falls-and-the-word-ends", SPI1->SR, SR_TXE | SR_RXNE | SR_FRLVL(1));
}

// --- FIFOs and data packing (35.5.9)

static void fifos(void)
{
    restart(MASTER | SLOW, CR2_DS(8));
    SPI1_DR16 = 0x0201;
    uint32_t begun = SPI1->SR;
    wait_cycles(12 * CLOCK(7));
    uint32_t half = SPI1->SR;
    idle();
    check_equal("the-first-of-two-goes-at-once", begun, SR_TXE | SR_BSY | SR_FTLVL(1));
    check_equal("one-is-below-the-threshold", half, SR_TXE | SR_BSY | SR_FRLVL(1));
    check_equal("two-are-RXNE", SPI1->SR, SR_TXE | SR_RXNE | SR_FRLVL(2));
    (void)SPI1_DR16;
    check_equal("one-access-takes-both", SPI1->SR, SR_TXE);
    SPI1_DR8 = 3;
    idle();
    check_equal("an-odd-one", SPI1->SR, SR_TXE | SR_FRLVL(1));
    SPI1->CR2 |= CR2_FRXTH;
    check_equal("takes-the-other-threshold", SPI1->SR, SR_TXE | SR_RXNE | SR_FRLVL(1));

    RCC_APB2RSTR = RCC_APB2_SPI1;
    RCC_APB2RSTR = 0;
    SPI1_DR8 = 1;
    check_equal("a-quarter", SPI1->SR, SR_TXE | SR_FTLVL(1));
    SPI1_DR8 = 2;
    check_equal("half", SPI1->SR, SR_TXE | SR_FTLVL(2));
    SPI1_DR8 = 3;
    check_equal("counts-as-full", SPI1->SR, SR_FTLVL(3));
}

// --- Errors (35.5.11)

static void errors(void)
{
    pull(MISO, false);
    restart(MASTER, CR2_DS(8) | CR2_FRXTH);
    for (unsigned word = 0; word < 4; ++word) {
        SPI1_DR8 = 0;
        idle();
    }
    check_equal("four-have-room", SPI1->SR, SR_TXE | SR_RXNE | SR_FRLVL(3));
    pull(MISO, true);
    SPI1_DR8 = 0;
    idle();
    check_equal("overrun", SPI1->SR & SR_OVR, SR_OVR);
    check_equal("SR-alone-keeps-it", SPI1->SR & SR_OVR, SR_OVR);
    uint32_t all = 0;
    for (unsigned word = 0; word < 4; ++word)
        all |= SPI1_DR8;
    check_equal("what-was-there-stays", all, 0);
    (void)SPI1->SR;
    check_equal("DR-and-SR-end-it", SPI1->SR, SR_TXE);

    SPI1->CR1 = CR1_MSTR | CR1_SSM | CR1_SPE;
    check_equal("mode-fault-by-SSI", SPI1->CR1 & (CR1_SPE | CR1_MSTR), 0);
    check_equal("MODF", SPI1->SR & SR_MODF, SR_MODF);
    SPI1->CR1 = MASTER | CR1_SPE;
    check_equal("SR-and-CR1-end-it", SPI1->SR & SR_MODF, 0);
}

// --- NSS (35.5.5, 35.5.12, 35.5.13)

static void slave_select(void)
{
    pin_alternate('A', NSS, AF_SPI1);
    restart(CR1_MSTR, CR2_DS(8) | CR2_FRXTH | CR2_SSOE);
    check("low-while-it-is-on", !pin_read('A', NSS));
    restart(CR1_MSTR | SLOW, CR2_DS(8) | CR2_SSOE | CR2_NSSP);
    check("high-before-a-word", pin_read('A', NSS));
    SPI1_DR16 = 0;
    bool within = pin_read('A', NSS);
    wait_cycles(8 * CLOCK(7) + CLOCK(7) / 2);
    bool between = pin_read('A', NSS), busy = SPI1->SR & SR_BSY;
    wait_cycles(CLOCK(7));
    bool second = pin_read('A', NSS);
    idle();
    check("low-within-one", !within && !second);
    check("a-pulse-between-two", between && busy);

    restart(CR1_MSTR | CR1_CPOL | SLOW, CR2_DS(8) | CR2_FRF); // 35.5.13
    bool rest = pin_read('A', NSS), clock_rest = pin_read('A', SCK);
    SPI1_DR16 = 0;
    wait_cycles(CLOCK(7) / 2);
    bool announced = pin_read('A', NSS);
    wait_cycles(CLOCK(7));
    within = pin_read('A', NSS);
    wait_cycles(8 * CLOCK(7));
    second = pin_read('A', NSS);
    idle();
    check("ti-mode-rests-low", !rest && !clock_rest && !pin_read('A', NSS));
    check("a-pulse-announces-each-word", announced && !within && second);
    check_equal("two-came", SPI1->SR, SR_TXE | SR_RXNE | SR_FRLVL(2));
    pin_mode('A', NSS, PIN_INPUT);
}

// --- CRC (35.5.14)

static void crc(void)
{
    pull(MISO, true);
    restart(MASTER | CR1_CRCEN, CR2_DS(8) | CR2_FRXTH);
    transfer('1', false);
    SPI1_DR8 = '2';
    SPI1->CR1 |= CR1_CRCNEXT;
    wait_until(SPI1->SR & SR_RXNE);
    (void)SPI1_DR8;
    check_equal("tx-crc", SPI1->TXCRCR, 0x72);
    check_equal("rx-crc-of-two-FF", SPI1->RXCRCR, 0x24);
    check("the-crc-follows", wait_until(SPI1->SR & SR_RXNE));
    check("what-came-in-is-none", SPI1->SR & SR_CRCERR);
    SPI1->SR = 0;
    check("CRCERR-clears-by-0", !(SPI1->SR & SR_CRCERR));

    RCC_APB2RSTR = RCC_APB2_SPI1;
    RCC_APB2RSTR = 0;
    SPI1->CRCPR = 0x1021;
    SPI1->CR2 = CR2_DS(8) | CR2_FRXTH;
    SPI1->CR1 = MASTER | CR1_CRCEN | CR1_CRCL | CR1_BR(5);
    SPI1->CR1 |= CR1_SPE;
    static const char text[] = "123456789";
    for (unsigned at = 0; at < 9; ++at) {
        SPI1_DR8 = (uint8_t)text[at];
        if (at == 8)
            SPI1->CR1 |= CR1_CRCNEXT;
        wait_until(SPI1->SR & SR_RXNE);
        (void)SPI1_DR8;
    }
    uint32_t start = DWT->CYCCNT;
    idle();
    uint32_t took = DWT->CYCCNT - start;
    check_equal("crc-of-16-bits", SPI1->TXCRCR, 0x31C3);
    check_range("goes-as-two-words-of-8", took, 15 * CLOCK(5), 17 * CLOCK(5));
    check_equal("and-both-came", SPI1->SR & SR_FRLVL(3), SR_FRLVL(2));
}

// --- Interrupts, DMA

static void lines(void)
{
    restart(MASTER, CR2_DS(8) | CR2_FRXTH);
    forget(SPI1_IRQ);
    SPI1->CR2 |= CR2_RXNEIE;
    check("none-without-a-word", !pending(SPI1_IRQ));
    SPI1_DR8 = 1;
    idle();
    check("RXNEIE", pending(SPI1_IRQ));
    (void)SPI1_DR8;
    forget(SPI1_IRQ);
    check("DR-takes-it-away-too", !pending(SPI1_IRQ));
    SPI1->CR2 = CR2_DS(8) | CR2_TXEIE;
    check("TXEIE", pending(SPI1_IRQ));
    SPI1->CR2 = CR2_DS(8);
    forget(SPI1_IRQ);
}

static uint8_t out[6] = {1, 2, 3, 4, 5, 6}, in[6];

static void stream(unsigned number, volatile void *memory, uint32_t count, uint32_t control)
{
    DMA2->S[number].CR = 0;
    DMA2->S[number].PAR = (uint32_t)&SPI1->DR;
    DMA2->S[number].M0AR = (uint32_t)memory;
    DMA2->S[number].NDTR = count;
    DMA2->S[number].CR = control | DMA_CHANNEL(DMA_SPI1) | DMA_PSIZE(1) | DMA_MSIZE(1) | DMA_MINC;
    DMA2->S[number].CR |= DMA_EN;
}

// Five words by three accesses of 16 bits each way, in the order of section 35.5.9: receiving first.
static void packed_dma(void)
{
    RCC_APB2RSTR = RCC_APB2_SPI1;
    RCC_APB2RSTR = 0;
    SPI1->CR2 = CR2_DS(8) | CR2_LDMA_RX | CR2_LDMA_TX | CR2_RXDMAEN;
    DMA2->LIFCR = 0x0F7D0F7D;
    stream(DMA_RX, in, 3, 0);
    stream(DMA_TX, out, 3, DMA_TO_PERIPHERAL);
    SPI1->CR2 |= CR2_TXDMAEN;
    SPI1->CR1 = MASTER | CR1_BR(4);
    uint32_t start = DWT->CYCCNT;
    SPI1->CR1 |= CR1_SPE;
    check("received-to-the-end", wait_until(DMA2->LISR & DMA_TCIF));
    wait_until(!(SPI1->SR & SR_FTLVL(3)));
    idle();
    uint32_t took = DWT->CYCCNT - start;
    check("sent-to-the-end", DMA2->LISR >> 22 & DMA_TCIF);
    check_range("five-words", took, 40 * CLOCK(4), 40 * CLOCK(4) + 3000);
    check_equal("five-came", in[0] & in[1] & in[2] & in[3] & in[4], 0xFF);
    check_equal("and-no-sixth", in[5], 0);
    check_equal("none-was-lost", SPI1->SR, SR_TXE);
}

int main(void)
{
    cycles_start();
    clock_start();
    RCC->AHB1ENR |= RCC_AHB1_GPIO('A') | RCC_AHB1_DMA2;
    RCC->APB2ENR |= RCC_APB2_SPI1;
    for (unsigned pin = SCK; pin <= MOSI; ++pin)
        pin_alternate('A', pin, AF_SPI1);
    words();
    fifos();
    errors();
    slave_select();
    crc();
    lines();
    packed_dma();
    check_done();
}
