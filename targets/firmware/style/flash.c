// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: drivers of a serial flash (W25Q, 32 to 128 Mbit) on SPI1 (PA5 to PA7) with its chip select on PA4, in mode 0
// at 9 MHz. It identifies the flash, erases a sector and sees that it is empty, programs three pages and reads them back:
// polled, by RXNE interrupts, by DMA. Everything that can go wrong is an answer: no flash, a flash that stays busy, bytes that
// differ. USART1 (PA9), 115200 8N1, says what was found; PC13 is lit when all is well.

#include "chip/spi.h"
#include "chip/stm32f103.h"
#include "clock.h"
#include "cycles.h"
#include "handlers.h"
#include "pin.h"
#include "text.h"

#define BAUD 115200u
#define LED 13
#define CS 4
#define PLACE 0x012000u
#define PAGE 256u
#define BUSY 1u
#define LIMIT_MS 500u

enum way { POLLED, BY_INTERRUPT, BY_DMA, WAYS };
static const char *const way_names[] = {"polled", "by interrupt", "by dma"};

static uint8_t sent[PAGE], found[PAGE];

static void send(const char *text)
{
    for (; *text; ++text) {
        while (!(USART1->SR & USART_SR_TXE)) {
        }
        USART1->DR = (uint8_t)*text;
    }
}

// --- A byte at a time

static uint8_t swap(uint8_t byte)
{
    while (!(SPI1->SR & SPI_SR_TXE)) {
    }
    SPI1->DR = byte;
    while (!(SPI1->SR & SPI_SR_RXNE)) {
    }
    return (uint8_t)SPI1->DR;
}

static void select(void) { pin_write(GPIOA, CS, false); }

static void release(void)
{
    while (SPI1->SR & SPI_SR_BSY) {
    }
    pin_write(GPIOA, CS, true);
    wait_cycles(8); // chip select stays high for 50 ns
}

static void begin(uint8_t command, uint32_t address)
{
    select();
    swap(command);
    swap((uint8_t)(address >> 16));
    swap((uint8_t)(address >> 8));
    swap((uint8_t)address);
}

// --- Many bytes, each way

static const uint8_t *volatile from;
static uint8_t *volatile into;
static volatile uint32_t left;

void SPI1_IRQHandler(void)
{
    uint8_t byte = (uint8_t)SPI1->DR;
    if (into)
        *into++ = byte;
    if (--left)
        SPI1->DR = from ? *from++ : 0xFF;
    else
        SPI1->CR2 = 0;
}

static void by_interrupt(const uint8_t *data, uint8_t *buffer, uint32_t count)
{
    from = data;
    into = buffer;
    left = count;
    SPI1->CR2 = SPI_CR2_RXNEIE;
    SPI1->DR = from ? *from++ : 0xFF;
    while (left)
        WFI();
}

static volatile bool through;

void DMA1_Channel2_IRQHandler(void)
{
    DMA1->IFCR = DMA_GIF(DMA_SPI1_RX);
    through = true;
}

static void channel(unsigned number, volatile void *memory, uint32_t count, uint32_t more)
{
    DMA1_CHANNEL(number)->CCR = 0;
    DMA1_CHANNEL(number)->CPAR = (uint32_t)(uintptr_t)&SPI1->DR;
    DMA1_CHANNEL(number)->CMAR = (uint32_t)(uintptr_t)memory;
    DMA1_CHANNEL(number)->CNDTR = count;
    DMA1_CHANNEL(number)->CCR = more | DMA_CCR_EN;
}

static void by_dma(const uint8_t *data, uint8_t *buffer, uint32_t count)
{
    static uint8_t ones = 0xFF, nowhere;
    through = false;
    channel(DMA_SPI1_RX, buffer ? buffer : &nowhere, count, DMA_CCR_TCIE | (buffer ? DMA_CCR_MINC : 0));
    channel(DMA_SPI1_TX, data ? (volatile void *)(uintptr_t)data : &ones, count,
            DMA_CCR_FROM_MEMORY | (data ? DMA_CCR_MINC : 0));
    SPI1->CR2 = SPI_CR2_RXDMAEN | SPI_CR2_TXDMAEN;
    while (!through)
        WFI();
    SPI1->CR2 = 0;
}

static void exchange(enum way way, const uint8_t *data, uint8_t *buffer, uint32_t count)
{
    if (way == BY_INTERRUPT)
        by_interrupt(data, buffer, count);
    else if (way == BY_DMA)
        by_dma(data, buffer, count);
    else
        for (uint32_t at = 0; at < count; ++at) {
            uint8_t byte = swap(data ? data[at] : 0xFF);
            if (buffer)
                buffer[at] = byte;
        }
}

// --- The flash

static uint32_t identify(void)
{
    select();
    swap(0x9F);
    uint32_t identity = (uint32_t)swap(0xFF) << 16;
    identity |= (uint32_t)swap(0xFF) << 8;
    identity |= swap(0xFF);
    release();
    return identity;
}

static bool ready(void)
{
    for (uint32_t start = cycles(); cycles() - start < LIMIT_MS * 72000u;) {
        select();
        swap(0x05);
        uint8_t status = swap(0xFF);
        release();
        if (!(status & BUSY))
            return true;
        wait_cycles(7200);
    }
    return false;
}

static void enable(void)
{
    select();
    swap(0x06);
    release();
}

static bool erase(uint32_t address)
{
    enable();
    begin(0x20, address);
    release();
    return ready();
}

static bool program(enum way way, uint32_t address)
{
    enable();
    begin(0x02, address);
    exchange(way, sent, 0, PAGE);
    release();
    return ready();
}

static void read(enum way way, uint32_t address)
{
    begin(0x03, address);
    exchange(way, 0, found, PAGE);
    release();
}

static const char *try_page(enum way way, uint32_t address)
{
    read(way, address);
    for (uint32_t at = 0; at < PAGE; ++at)
        if (found[at] != 0xFF)
            return "not empty";
    for (uint32_t at = 0; at < PAGE; ++at)
        sent[at] = (uint8_t)(at * 7 + way);
    if (!program(way, address))
        return "stays busy";
    read(way, address);
    for (uint32_t at = 0; at < PAGE; ++at)
        if (found[at] != sent[at])
            return "differs";
    return "ok";
}

int main(void)
{
    clock_72mhz();
    cycles_start();
    RCC->AHBENR |= RCC_AHB_DMA1;
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_GPIOC | RCC_APB2_SPI1 | RCC_APB2_USART1;
    pin_write(GPIOA, CS, true);
    pin_mode(GPIOA, CS, PIN_OUTPUT);
    pin_mode(GPIOA, 5, PIN_ALTERNATE);
    pin_pull(GPIOA, 6, true);
    pin_mode(GPIOA, 7, PIN_ALTERNATE);
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    pin_write(GPIOC, LED, true);
    pin_mode(GPIOC, LED, PIN_OUTPUT);
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE;
    SPI1->CR1 = SPI_CR1_MSTR | SPI_CR1_SSM | SPI_CR1_SSI | 2u << SPI_CR1_BR_SHIFT;
    SPI1->CR1 |= SPI_CR1_SPE;
    irq_line_enable(SPI1_IRQ);
    irq_line_enable(DMA1_CHANNEL1_IRQ + DMA_SPI1_RX - 1);

    uint32_t identity = identify();
    struct line line = EMPTY_LINE;
    line_text(&line, "identity ");
    line_hex(&line, identity);
    line_text(&line, "\r\n");
    send(line.text);
    bool good = identity >> 16 == 0xEF;
    if (!good)
        send("no flash\r\n");
    else if (!erase(PLACE)) {
        send("stays busy\r\n");
        good = false;
    }
    for (enum way way = POLLED; good && way < WAYS; ++way) {
        const char *what = try_page(way, PLACE + PAGE * way);
        send(way_names[way]);
        send(": ");
        send(what);
        send("\r\n");
        good = what[0] == 'o';
    }
    pin_write(GPIOC, LED, !good);
    for (;;)
        WFI();
}
