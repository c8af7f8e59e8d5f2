// SPDX-License-Identifier: GPL-2.0-or-later
//
// A serial flash at a Nucleo-H753ZI, at 16 MHz; see nucleo_flash.h. Each exchange is a transfer of its own with TSIZE, in
// packets of four words, or of one where there are not as many (RM0433, sections 50.4.9 to 50.4.14).

#include "h753/clock.h"
#include "h753/spi.h"

#define CORE_HZ CPU_HZ
#define DMA_COUNT 255u // no multiple of a packet
#define PAGES ((uint8_t *)0x24000000u) // AXI SRAM, which DMA reaches

#define COUNTER_START counter_start

#include "nucleo_flash.h"

enum { DMA1_STREAM0_IRQ = 11, PACKET = 4 };

// Section 50.4.9 and 50.4.10: settings first, then SPE, then CSTART.
static void start(uint32_t count, uint32_t cfg1, uint32_t ier)
{
    SPI1->CFG1 = DSIZE(8) | CRCSIZE(8) | FTHLV(count < PACKET ? 1 : PACKET) | MBR(1) | cfg1;
    SPI1->CR2 = count;
    SPI1->IER = ier;
    SPI1->CR1 = SSI | SPE;
    SPI1->CR1 = SSI | SPE | CSTART;
}

// Section 50.4.12: the end of the transfer is there already.
static void finish(void)
{
    SPI1->IFCR = EOT | TXTF;
    SPI1->CR1 = SSI;
    SPI1->CFG1 &= ~(RXDMAEN | TXDMAEN);
}

static const uint8_t *from;
static uint8_t *into;
static uint32_t to_send, to_receive;
static volatile bool through;

static uint32_t next_words(unsigned count)
{
    uint32_t words = 0xFFFFFFFFu;
    for (unsigned at = 0; from && at < count; ++at)
        words = (words & ~(0xFFu << 8 * at)) | (uint32_t)*from++ << 8 * at;
    to_send -= count;
    return words;
}

static void keep(uint32_t words, unsigned count)
{
    for (unsigned at = 0; into && at < count; ++at)
        *into++ = (uint8_t)(words >> 8 * at);
    to_receive -= count;
}

// A packet each way, as far as flags allow; at EOT what makes no packet, by what RXWNE and RXPLVL say.
static void serve(uint32_t flags, unsigned packet)
{
    if (flags & TXP && to_send >= packet) {
        if (packet == PACKET)
            SPI1->TXDR = next_words(PACKET);
        else
            SPI1_TXDR8 = (uint8_t)next_words(1);
    } else if (flags & TXP) {
        while (to_send)
            SPI1_TXDR8 = (uint8_t)next_words(1);
    }
    if (flags & RXP && to_receive >= packet) {
        if (packet == PACKET)
            keep(SPI1->RXDR, PACKET);
        else
            keep(SPI1_RXDR8, 1);
    }
    if (flags & EOT)
        while (SPI1->SR & (RXWNE | RXPLVL(3)))
            keep(SPI1_RXDR8, 1);
}

static void prepare(const uint8_t *data, uint8_t *buffer, uint32_t count)
{
    from = data;
    into = buffer;
    to_send = to_receive = count;
    through = false;
}

static void polled(uint32_t count)
{
    start(count, 0, 0);
    uint32_t flags;
    do
        serve(flags = SPI1->SR, count < PACKET ? 1 : PACKET);
    while (!(flags & EOT));
}

// TXPIE falls by TXTF; EOTIE brings the end.
static void served(void)
{
    uint32_t flags = SPI1->SR;
    serve(flags, PACKET);
    if (flags & EOT) {
        SPI1->IER = 0;
        through = true;
    }
}

static void by_interrupt(uint32_t count)
{
    handle(SPI1_IRQ, served);
    start(count, 0, RXP | TXP | EOT);
    while (!through)
        WFI();
}

static void received(void)
{
    DMA1->LIFCR = DMA_ALL;
    through = true;
}

static void stream(unsigned number, uint32_t request, volatile void *port, const volatile void *memory, uint32_t count,
                   uint32_t control)
{
    DMA1->S[number].CR = 0;
    while (DMA1->S[number].CR & DMA_EN) {
    }
    DMA1->LIFCR = DMA_ALL << 6 * number;
    DMAMUX1[number] = request;
    DMA1->S[number].PAR = (uint32_t)port;
    DMA1->S[number].M0AR = (uint32_t)memory;
    DMA1->S[number].NDTR = count;
    DMA1->S[number].CR = control;
    DMA1->S[number].CR |= DMA_EN;
}

// Section 50.4.14: RXDMAEN, the streams, TXDMAEN, and then SPE.
static void by_dma(uint32_t count)
{
    volatile uint8_t *ones = PAGES + 2 * PAGE, *nowhere = ones + 1;
    *ones = 0xFF;
    DSB();
    handle(DMA1_STREAM0_IRQ, received);
    SPI1->CFG1 |= RXDMAEN;
    stream(0, REQUEST_SPI1_RX, &SPI1->RXDR, into ? into : nowhere, count, DMA_TCIE | (into ? DMA_MINC : 0));
    stream(1, REQUEST_SPI1_TX, &SPI1->TXDR, from ? from : ones, count, DMA_TO_PERIPHERAL | (from ? DMA_MINC : 0));
    start(count, RXDMAEN | TXDMAEN, 0);
    while (!through)
        WFI();
    while (!(SPI1->SR & EOT)) {
    }
}

static void exchange(enum way way, const uint8_t *data, uint8_t *buffer, uint32_t count)
{
    prepare(data, buffer, count);
    if (way == BY_INTERRUPT)
        by_interrupt(count);
    else if (way == BY_DMA)
        by_dma(count);
    else
        polled(count);
    finish();
}

static void open_gates(void)
{
    RCC->AHB1ENR |= RCC_AHB1_DMA1;
    RCC->AHB4ENR |= RCC_AHB4_GPIO('A') | RCC_AHB4_GPIO('B') | RCC_AHB4_GPIO('D');
    RCC->APB1LENR |= RCC_APB1L_USART3;
    RCC->APB2ENR |= RCC_APB2_SPI1;
    RCC->D2CCIP1R = RCC_SPI123_PER;
    for (unsigned pin = SCK; pin <= MOSI; ++pin)
        pin_alternate('A', pin, AF_SPI1);
    GPIO('A')->PUPDR |= 1u << 2 * MISO;
    SPI1->CR1 = SSI;
    SPI1->CFG2 = MASTER | SSM | AFCNTR;
}
