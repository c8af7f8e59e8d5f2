// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: a graphics library on an SSD1306 of 128 x 64 at I2C1 (PB8, PB9, remapped) at 400 kHz. Its frame of 1 KB
// goes out by DMA in one message, with a box that moves a pixel every 40 ms; the commands of its start are polled. USART1
// (PA9), 115200 8N1, says how many frames were sent, or what went wrong.

#include "chip/dma.h"
#include "chip/i2c.h"
#include "chip/stm32f103.h"
#include "clock.h"
#include "cycles.h"
#include "pin.h"

#define BAUD 115200u
#define DISPLAY 0x3Cu
#define WIDTH 128u
#define PAGES 8u
#define LIMIT (72000u * 100u)
#define FRAME_CYCLES (72000u * 40u)
#define COMMANDS 0x00u
#define DATA 0x40u
#define MAPR_I2C1 (1u << 1)

static uint8_t frame[1 + WIDTH * PAGES] = {DATA};

static const uint8_t start_up[] = {
    COMMANDS, 0xAE,       // off
    0xD5,     0x80,       // clock
    0xA8,     63,         // 64 rows
    0xD3,     0,          // no offset
    0x40,                 // from the first line on
    0x8D,     0x14,       // charge pump
    0x20,     0x00,       // horizontal
    0xA1,     0xC8,       // from the top left
    0xDA,     0x12,       // wiring of the rows
    0x81,     0xCF,       // contrast
    0xD9,     0xF1, 0xDB, 0x40, 0xA4, 0xA6,
    0xAF, // on
};
static const uint8_t whole[] = {COMMANDS, 0x21, 0, WIDTH - 1, 0x22, 0, PAGES - 1};

static void send(const char *text)
{
    for (; *text; ++text) {
        while (!(USART1->SR & USART_SR_TXE)) {
        }
        USART1->DR = (uint8_t)*text;
    }
}

static void pixel(unsigned x, unsigned y, bool lit)
{
    uint8_t *byte = &frame[1 + x + y / 8 * WIDTH];
    *byte = (uint8_t)(lit ? *byte | 1u << y % 8 : *byte & ~(1u << y % 8));
}

static void box(unsigned x, unsigned y, unsigned size, bool lit)
{
    for (unsigned at = 0; at < size; ++at) {
        pixel(x + at, y, lit);
        pixel(x + at, y + size - 1, lit);
        pixel(x, y + at, lit);
        pixel(x + size - 1, y + at, lit);
    }
}

static bool event(uint32_t flag)
{
    for (uint32_t begin = cycles(); cycles() - begin < LIMIT;) {
        uint32_t status = I2C1->SR1;
        if (status & flag)
            return true;
        if (status & I2C_SR1_AF) {
            I2C1->SR1 = 0;
            break;
        }
    }
    I2C1->CR1 |= I2C_CR1_STOP;
    return false;
}

static bool begin(void)
{
    while (I2C1->SR2 & I2C_SR2_BUSY) {
    }
    I2C1->CR1 |= I2C_CR1_START;
    if (!event(I2C_SR1_SB))
        return false;
    I2C1->DR = DISPLAY << 1;
    if (!event(I2C_SR1_ADDR))
        return false;
    (void)I2C1->SR2;
    return true;
}

static bool end(void)
{
    if (!event(I2C_SR1_BTF))
        return false;
    I2C1->CR1 |= I2C_CR1_STOP;
    return true;
}

static bool polled(const uint8_t *bytes, uint32_t count)
{
    bool good = begin();
    for (; good && count; --count) {
        I2C1->DR = *bytes++;
        good = event(I2C_SR1_TXE);
    }
    return good && end();
}

static bool frame_by_dma(void)
{
    volatile dma_channel_t *channel = &DMA1->CHANNEL[DMA_I2C1_TX - 1];
    channel->CCR = 0;
    DMA1->IFCR = 0xFu << 4 * (DMA_I2C1_TX - 1);
    channel->CMAR = (uint32_t)(uintptr_t)frame;
    channel->CPAR = (uint32_t)(uintptr_t)&I2C1->DR;
    channel->CNDTR = sizeof frame;
    channel->CCR = DMA_CCR_MINC | DMA_CCR_FROM_MEMORY | DMA_CCR_EN;
    if (!begin())
        return false;
    I2C1->CR2 |= I2C_CR2_DMAEN;
    for (uint32_t since = cycles(); !(DMA1->ISR & 2u << 4 * (DMA_I2C1_TX - 1));)
        if (cycles() - since > LIMIT)
            return false;
    I2C1->CR2 &= ~I2C_CR2_DMAEN;
    return end();
}

int main(void)
{
    clock_72mhz();
    cycles_start();
    RCC->AHBENR |= RCC_AHB_DMA1;
    RCC->APB1ENR |= RCC_APB1_I2C1;
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOA | RCC_APB2_GPIOB | RCC_APB2_USART1;
    AFIO->MAPR = AFIO_MAPR_SWD_ONLY | MAPR_I2C1;
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    pin_mode(GPIOB, 8, PIN_ALTERNATE_OPEN_DRAIN);
    pin_mode(GPIOB, 9, PIN_ALTERNATE_OPEN_DRAIN);
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE;
    I2C1->CR2 = 36;
    I2C1->CCR = I2C_CCR_FAST | 30; // 36 MHz / (3 x 30)
    I2C1->TRISE = 36 * 300 / 1000 + 1;
    I2C1->CR1 = I2C_CR1_PE;

    if (!polled(start_up, sizeof start_up)) {
        send("no display\r\n");
        for (;;)
            WFI();
    }
    for (unsigned x = 0; x < WIDTH; ++x) { // a frame, and a mark at the top left
        pixel(x, 0, true);
        pixel(x, 63, true);
    }
    for (unsigned y = 0; y < 64; ++y) {
        pixel(0, y, true);
        pixel(WIDTH - 1, y, true);
    }
    box(4, 4, 6, true);
    char text[] = "frame 0\r\n";
    for (unsigned at = 0;; ++at) {
        uint32_t since = cycles();
        unsigned x = 16 + at % 90;
        box(x, 20, 20, true);
        if (!polled(whole, sizeof whole) || !frame_by_dma())
            send("not sent\r\n");
        box(x, 20, 20, false);
        text[6] = (char)('0' + at % 10);
        send(text);
        while (cycles() - since < FRAME_CYCLES) {
        }
    }
}
