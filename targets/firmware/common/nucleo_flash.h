// SPDX-License-Identifier: GPL-2.0-or-later
//
// A Nucleo-144 with a serial flash (W25Q, 32 to 128 Mbit) on SPI1 at the Arduino pins (SCK PA5, MISO PA6, MOSI PA7, chip
// select PD14). It identifies the flash, erases a sector, programs a page in each of three ways and reads it back: polled, by
// interrupts, by DMA. USART3 (the ST-LINK's virtual COM port, 115200 8N1) says what was found; LD1 is lit when all is well.
//
// The program of one board: included once, by a file that has the registers and clocks of its chip, and says how fast the
// core runs (CORE_HZ), where DMA reaches two pages of memory (PAGES), how many words go by DMA (DMA_COUNT), how to
// start the cycle counter (COUNTER_START), how to open gates and pins (open_gates) and to move words over SPI1 (exchange).

#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "chip/cpu.h"
#include "text.h"

#define BAUD 115200u
#define PLACE 0x012000u
#define PAGE 256u
#define BUSY 1u
#define LIMIT_MS 500u

enum { LD1 = 0, CS = 14, TX = 8, AF_USART3 = 7 };
enum way { POLLED, BY_INTERRUPT, BY_DMA, WAYS };

// Moves words over SPI1, and returns when the last one is through; without `data` ones are sent, without `buffer` what comes
// in is dropped.
static void exchange(enum way way, const uint8_t *data, uint8_t *buffer, uint32_t count);
static void open_gates(void);

static uint8_t *const sent = PAGES, *const found = PAGES + PAGE;

static void say(const char *text)
{
    for (; *text; ++text) {
        while (!(USART3->ISR & USART_ISR_TXE)) {
        }
        USART3->TDR = (uint8_t)*text;
    }
}

// Interrupts of an image by itself: the vector table is copied to RAM, and the handler of one is put there.
static void handle(unsigned irq, void (*handler)(void))
{
    static uint32_t table[256] __attribute__((aligned(1024)));
    const uint32_t *from = (const uint32_t *)SCB->VTOR;
    if (from != table) {
        for (unsigned number = 0; number < 16 + IRQ_COUNT; ++number)
            table[number] = from[number];
        SCB->VTOR = (uint32_t)table;
    }
    table[16 + irq] = (uint32_t)handler;
    DSB();
    interrupt_enable(irq, 1);
}

// --- The flash

static void select(void) { pin_write('D', CS, false); }

static void release(void)
{
    pin_write('D', CS, true);
    wait_cycles(CORE_HZ / 20000000u); // chip select stays high for 50 ns
}

static void send(const uint8_t *data, uint32_t count) { exchange(POLLED, data, 0, count); }

static void begin(uint8_t command, uint32_t address)
{
    uint8_t words[] = {command, (uint8_t)(address >> 16), (uint8_t)(address >> 8), (uint8_t)address};
    select();
    send(words, 4);
}

static uint32_t identify(void)
{
    static const uint8_t command = 0x9F;
    uint8_t words[3];
    select();
    send(&command, 1);
    exchange(POLLED, 0, words, 3);
    release();
    return (uint32_t)words[0] << 16 | (uint32_t)words[1] << 8 | words[2];
}

static bool ready(void)
{
    for (uint32_t start = DWT->CYCCNT; DWT->CYCCNT - start < LIMIT_MS * (CORE_HZ / 1000u);) {
        static const uint8_t command[2] = {0x05, 0xFF};
        uint8_t status[2];
        select();
        exchange(POLLED, command, status, 2);
        release();
        if (!(status[1] & BUSY))
            return true;
        wait_cycles(CORE_HZ / 10000u);
    }
    return false;
}

static void enable(void)
{
    static const uint8_t command = 0x06;
    select();
    send(&command, 1);
    release();
}

static bool erase(uint32_t address)
{
    enable();
    begin(0x20, address);
    release();
    return ready();
}

static bool program(enum way way, uint32_t address, uint32_t count)
{
    enable();
    begin(0x02, address);
    exchange(way, sent, 0, count);
    release();
    return ready();
}

static void read(enum way way, uint32_t address, uint32_t count)
{
    begin(0x03, address);
    exchange(way, 0, found, count);
    release();
}

static const char *try_page(enum way way, uint32_t address)
{
    uint32_t count = way == BY_DMA ? DMA_COUNT : PAGE;
    read(way, address, count);
    for (uint32_t at = 0; at < count; ++at)
        if (found[at] != 0xFF)
            return "not empty";
    for (uint32_t at = 0; at < count; ++at)
        sent[at] = (uint8_t)(at * 7 + way);
    if (!program(way, address, count))
        return "stays busy";
    read(way, address, count);
    for (uint32_t at = 0; at < count; ++at)
        if (found[at] != sent[at])
            return "differs";
    return "ok";
}

int main(void)
{
    static const char *const names[] = {"polled", "by interrupt", "by dma"};
    COUNTER_START();
    clock_start();
    open_gates();
    pin_write('D', CS, true);
    pin_mode('D', CS, PIN_OUTPUT);
    pin_alternate('D', TX, AF_USART3);
    USART3->BRR = (PCLK1_HZ + BAUD / 2) / BAUD;
    USART3->CR1 = USART_CR1_UE | USART_CR1_TE;

    uint32_t identity = identify();
    struct line line = EMPTY_LINE;
    line_text(&line, "identity ");
    line_hex(&line, identity);
    line_text(&line, "\r\n");
    say(line.text);
    bool good = identity >> 16 == 0xEF;
    if (!good)
        say("no flash\r\n");
    else if (!erase(PLACE)) {
        say("stays busy\r\n");
        good = false;
    }
    for (enum way way = POLLED; good && way < WAYS; ++way) {
        const char *what = try_page(way, PLACE + PAGE * way);
        say(names[way]);
        say(": ");
        say(what);
        say("\r\n");
        good = what[0] == 'o';
    }
    pin_write('B', LD1, good);
    pin_mode('B', LD1, PIN_OUTPUT);
    for (;;)
        WFI();
}
