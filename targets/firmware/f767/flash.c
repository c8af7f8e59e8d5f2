// SPDX-License-Identifier: GPL-2.0-or-later
//
// A serial flash at a Nucleo-F767ZI, at 13.5 MHz; see nucleo_flash.h. Two words go with each access where that is possible
// (RM0410, section 35.5.9, data packing), by DMA with an odd number of them.

#include "f767/clock.h"
#include "f767/spi.h"

#define CORE_HZ HCLK_HZ
#define DMA_COUNT 255u

static uint8_t pages[512] __attribute__((aligned(4)));
#define PAGES pages

#define COUNTER_START cycles_start

#include "nucleo_flash.h"

enum { DMA2_STREAM0_IRQ = 56 };
static const uint32_t ON = CR1_MSTR | CR1_SSM | CR1_SSI | CR1_BR(2) | CR1_SPE;

// Section 35.5.9, procedure for disabling the SPI.
static void finish(void)
{
    while (SPI1->SR & SR_FTLVL(3)) {
    }
    while (SPI1->SR & SR_BSY) {
    }
    SPI1->CR1 = ON & ~(uint32_t)CR1_SPE;
    while (SPI1->SR & SR_FRLVL(3))
        (void)SPI1_DR8;
}

static void start(uint32_t cr2)
{
    SPI1->CR2 = CR2_DS(8) | cr2;
    SPI1->CR1 = ON;
}

static uint8_t to_send(const uint8_t *data, uint32_t at) { return data ? data[at] : 0xFF; }

// Two by two; the last of an odd number takes the threshold of one word.
static void polled(const uint8_t *data, uint8_t *buffer, uint32_t count)
{
    uint32_t out = 0, in = 0;
    start(count == 1 ? CR2_FRXTH : 0);
    while (in < count) {
        if (out < count && out - in <= 2 && SPI1->SR & SR_TXE) {
            if (count - out >= 2) {
                SPI1_DR16 = (uint16_t)(to_send(data, out) | to_send(data, out + 1) << 8);
                out += 2;
            } else {
                SPI1_DR8 = to_send(data, out++);
            }
        }
        if (!(SPI1->SR & SR_RXNE))
            continue;
        uint32_t words = count - in >= 2 ? SPI1_DR16 : SPI1_DR8;
        for (unsigned each = count - in >= 2 ? 2 : 1; each; --each, words >>= 8, ++in)
            if (buffer)
                buffer[in] = (uint8_t)words;
        if (count - in == 1)
            SPI1->CR2 |= CR2_FRXTH;
    }
}

static const uint8_t *volatile from;
static uint8_t *volatile into;
static volatile uint32_t left;

static void received(void)
{
    uint8_t word = SPI1_DR8;
    if (into)
        *into++ = word;
    if (--left)
        SPI1_DR8 = from ? *from++ : 0xFF;
    else
        SPI1->CR2 &= ~(uint32_t)CR2_RXNEIE;
}

static void by_interrupt(const uint8_t *data, uint8_t *buffer, uint32_t count)
{
    from = data;
    into = buffer;
    left = count;
    handle(SPI1_IRQ, received);
    start(CR2_FRXTH | CR2_RXNEIE);
    SPI1_DR8 = from ? *from++ : 0xFF;
    while (left)
        WFI();
}

static volatile bool through;

static void transferred(void)
{
    DMA2->LIFCR = DMA_ALL;
    through = true;
}

static void stream(unsigned number, const volatile void *memory, uint32_t count, uint32_t control)
{
    DMA2->S[number].CR = 0;
    while (DMA2->S[number].CR & DMA_EN) {
    }
    DMA2->LIFCR = number == DMA_RX ? DMA_ALL : DMA_ALL << 22;
    DMA2->S[number].PAR = (uint32_t)&SPI1->DR;
    DMA2->S[number].M0AR = (uint32_t)memory;
    DMA2->S[number].NDTR = count;
    DMA2->S[number].CR = control | DMA_CHANNEL(DMA_SPI1) | DMA_PSIZE(1) | DMA_MSIZE(1);
    DMA2->S[number].CR |= DMA_EN;
}

// Communication using DMA: its order is that of the section.
static void by_dma(const uint8_t *data, uint8_t *buffer, uint32_t count)
{
    static uint16_t ones = 0xFFFF, nowhere;
    uint32_t odd = count & 1 ? CR2_LDMA_RX | CR2_LDMA_TX : 0, accesses = (count + 1) / 2;
    through = false;
    handle(DMA2_STREAM0_IRQ, transferred);
    SPI1->CR2 = CR2_DS(8) | odd | CR2_RXDMAEN;
    stream(DMA_RX, buffer ? (void *)buffer : &nowhere, accesses, DMA_TCIE | (buffer ? DMA_MINC : 0));
    stream(DMA_TX, data ? (const void *)data : &ones, accesses, DMA_TO_PERIPHERAL | (data ? DMA_MINC : 0));
    start(odd | CR2_RXDMAEN | CR2_TXDMAEN);
    while (!through)
        WFI();
}

static void exchange(enum way way, const uint8_t *data, uint8_t *buffer, uint32_t count)
{
    if (way == BY_INTERRUPT)
        by_interrupt(data, buffer, count);
    else if (way == BY_DMA)
        by_dma(data, buffer, count);
    else
        polled(data, buffer, count);
    finish();
    SPI1->CR2 = CR2_DS(8);
}

static void open_gates(void)
{
    RCC->AHB1ENR |= RCC_AHB1_GPIO('A') | RCC_AHB1_GPIO('B') | RCC_AHB1_GPIO('D') | RCC_AHB1_DMA2;
    RCC->APB1ENR |= RCC_APB1_USART3;
    RCC->APB2ENR |= RCC_APB2_SPI1;
    for (unsigned pin = SCK; pin <= MOSI; ++pin)
        pin_alternate('A', pin, AF_SPI1);
    GPIO('A')->PUPDR |= 1u << 2 * MISO;
    SPI1->CR1 = ON & ~(uint32_t)CR1_SPE;
}
