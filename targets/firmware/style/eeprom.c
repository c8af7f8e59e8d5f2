// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: drivers of an EEPROM 24C02 on I2C1 (PB6, PB7) at 400 kHz. A page is written and read back in three ways:
// polled, by interrupts as a state machine, by DMA; between them the EEPROM is asked until it answers again. All reads are
// by the book: one byte, two with POS, more. Everything that can go wrong is an answer. USART1 (PA9), 115200 8N1, says what
// was found; PC13 is lit when all is well.

#include "chip/i2c.h"
#include "chip/stm32f103.h"
#include "clock.h"
#include "cycles.h"
#include "handlers.h"
#include "pin.h"

#define BAUD 115200u
#define LED 13
#define EEPROM 0x50u
#define PAGE 8u
#define LIMIT (72000u * 10u) // 10 ms

static void send(const char *text)
{
    for (; *text; ++text) {
        while (!(USART1->SR & USART_SR_TXE)) {
        }
        USART1->DR = (uint8_t)*text;
    }
}

// --- Events, waited for with a limit

static const char *trouble;

static bool event(uint32_t flags)
{
    for (uint32_t begin = cycles(); cycles() - begin < LIMIT;) {
        uint32_t status = I2C1->SR1;
        if ((status & flags) == flags)
            return true;
        if (status & (I2C_SR1_AF | I2C_SR1_ARLO)) {
            trouble = status & I2C_SR1_AF ? "no acknowledge" : "arbitration lost";
            I2C1->SR1 = 0;
            I2C1->CR1 |= I2C_CR1_STOP;
            return false;
        }
    }
    trouble = "no event";
    I2C1->CR1 = I2C_CR1_SWRST;
    return false;
}

static bool is_free(void)
{
    for (uint32_t begin = cycles(); I2C1->SR2 & I2C_SR2_BUSY;)
        if (cycles() - begin > LIMIT) {
            trouble = "bus busy";
            return false;
        }
    return true;
}

static bool begin(uint32_t direction, bool acknowledge)
{
    I2C1->CR1 = (I2C1->CR1 & ~I2C_CR1_ACK) | I2C_CR1_START | (acknowledge ? I2C_CR1_ACK : 0);
    if (!event(I2C_SR1_SB))
        return false;
    I2C1->DR = EEPROM << 1 | direction;
    return event(I2C_SR1_ADDR);
}

static bool place(uint8_t address)
{
    if (!begin(0, false))
        return false;
    (void)I2C1->SR2;
    I2C1->DR = address;
    return event(I2C_SR1_TXE);
}

// --- Polled

static bool write_polled(uint8_t address, const uint8_t *data, uint32_t count)
{
    if (!is_free() || !place(address))
        return false;
    for (; count; --count) {
        I2C1->DR = *data++;
        if (!event(I2C_SR1_TXE))
            return false;
    }
    if (!event(I2C_SR1_BTF))
        return false;
    I2C1->CR1 |= I2C_CR1_STOP;
    return is_free();
}

static bool read_polled(uint8_t address, uint8_t *data, uint32_t count)
{
    if (!is_free() || !place(address) || !event(I2C_SR1_BTF))
        return false;
    if (count == 2)
        I2C1->CR1 |= I2C_CR1_POS;
    if (!begin(1, count > 1))
        return false;
    if (count == 1) {
        (void)I2C1->SR2;
        I2C1->CR1 |= I2C_CR1_STOP;
        if (!event(I2C_SR1_RXNE))
            return false;
        *data = (uint8_t)I2C1->DR;
    } else if (count == 2) {
        (void)I2C1->SR2;
        I2C1->CR1 &= ~I2C_CR1_ACK;
        if (!event(I2C_SR1_BTF))
            return false;
        I2C1->CR1 |= I2C_CR1_STOP;
        *data++ = (uint8_t)I2C1->DR;
        *data = (uint8_t)I2C1->DR;
        I2C1->CR1 &= ~I2C_CR1_POS;
    } else {
        (void)I2C1->SR2;
        for (; count > 3; --count) {
            if (!event(I2C_SR1_RXNE))
                return false;
            *data++ = (uint8_t)I2C1->DR;
        }
        if (!event(I2C_SR1_BTF))
            return false;
        I2C1->CR1 &= ~I2C_CR1_ACK;
        *data++ = (uint8_t)I2C1->DR;
        if (!event(I2C_SR1_BTF))
            return false;
        I2C1->CR1 |= I2C_CR1_STOP;
        *data++ = (uint8_t)I2C1->DR;
        if (!event(I2C_SR1_RXNE))
            return false;
        *data = (uint8_t)I2C1->DR;
    }
    return is_free();
}

// --- By interrupts: what a message is, and where it stands

static struct {
    uint8_t *data;
    uint32_t left;
    uint8_t address;
    bool reading, placed;
} message;
static volatile bool over, failed;

void I2C1_EV_IRQHandler(void)
{
    uint32_t status = I2C1->SR1;
    if (status & I2C_SR1_SB) {
        I2C1->DR = EEPROM << 1 | (message.reading && message.placed);
    } else if (status & I2C_SR1_ADDR) {
        if (message.reading && message.placed && message.left == 1)
            I2C1->CR1 &= ~I2C_CR1_ACK;
        (void)I2C1->SR2;
        if (!message.placed)
            I2C1->DR = message.address;
        else if (message.left == 1)
            I2C1->CR1 |= I2C_CR1_STOP;
    } else if (status & I2C_SR1_RXNE) {
        *message.data++ = (uint8_t)I2C1->DR;
        if (--message.left == 1) {
            I2C1->CR1 = (I2C1->CR1 & ~I2C_CR1_ACK) | I2C_CR1_STOP;
        } else if (!message.left) {
            I2C1->CR2 &= ~(I2C_CR2_ITEVTEN | I2C_CR2_ITBUFEN);
            over = true;
        }
    } else if (status & I2C_SR1_TXE) {
        message.placed = true;
        if (message.reading) {
            if (status & I2C_SR1_BTF)
                I2C1->CR1 |= I2C_CR1_START | I2C_CR1_ACK;
        } else if (message.left) {
            I2C1->DR = *message.data++;
            --message.left;
        } else if (status & I2C_SR1_BTF) {
            I2C1->CR1 |= I2C_CR1_STOP;
            I2C1->CR2 &= ~(I2C_CR2_ITEVTEN | I2C_CR2_ITBUFEN);
            over = true;
        }
    }
}

void I2C1_ER_IRQHandler(void)
{
    I2C1->SR1 = 0;
    I2C1->CR1 |= I2C_CR1_STOP;
    I2C1->CR2 &= ~(I2C_CR2_ITEVTEN | I2C_CR2_ITBUFEN);
    failed = over = true;
}

static bool by_interrupt(bool reading, uint8_t address, uint8_t *data, uint32_t count)
{
    if (!is_free())
        return false;
    message.data = data;
    message.left = count;
    message.address = address;
    message.reading = reading;
    message.placed = over = failed = false;
    I2C1->CR2 |= I2C_CR2_ITEVTEN | I2C_CR2_ITBUFEN | I2C_CR2_ITERREN;
    I2C1->CR1 |= I2C_CR1_START;
    while (!over)
        WFI();
    I2C1->CR2 &= ~I2C_CR2_ITERREN;
    if (failed)
        trouble = "no acknowledge";
    return !failed && is_free();
}

// --- By DMA

static void channel(unsigned number, uint8_t *memory, uint32_t count, uint32_t more)
{
    DMA1->IFCR = DMA_GIF(number);
    DMA1_CHANNEL(number)->CCR = 0;
    DMA1_CHANNEL(number)->CPAR = (uint32_t)(uintptr_t)&I2C1->DR;
    DMA1_CHANNEL(number)->CMAR = (uint32_t)(uintptr_t)memory;
    DMA1_CHANNEL(number)->CNDTR = count;
    DMA1_CHANNEL(number)->CCR = DMA_CCR_MINC | more | DMA_CCR_EN;
}

static bool through(unsigned number)
{
    for (uint32_t begin = cycles(); !(DMA1->ISR & DMA_TCIF(number));)
        if (cycles() - begin > LIMIT) {
            trouble = "dma stands still";
            return false;
        }
    return true;
}

static bool write_by_dma(uint8_t address, uint8_t *data, uint32_t count)
{
    if (!is_free() || !place(address))
        return false;
    channel(DMA_I2C1_TX, data, count, DMA_CCR_FROM_MEMORY);
    I2C1->CR2 |= I2C_CR2_DMAEN;
    bool good = through(DMA_I2C1_TX) && event(I2C_SR1_BTF);
    I2C1->CR2 &= ~I2C_CR2_DMAEN;
    I2C1->CR1 |= I2C_CR1_STOP;
    return good && is_free();
}

static bool read_by_dma(uint8_t address, uint8_t *data, uint32_t count)
{
    if (!is_free() || !place(address) || !event(I2C_SR1_BTF) || !begin(1, true))
        return false;
    channel(DMA_I2C1_RX, data, count, 0);
    I2C1->CR2 |= I2C_CR2_DMAEN | I2C_CR2_LAST;
    (void)I2C1->SR2;
    bool good = through(DMA_I2C1_RX);
    I2C1->CR1 |= I2C_CR1_STOP;
    I2C1->CR2 &= ~(I2C_CR2_DMAEN | I2C_CR2_LAST);
    return good && is_free();
}

// --- What is tried

static bool answers_again(void)
{
    for (uint32_t tries = 0; tries < 200; ++tries) {
        if (begin(0, false)) {
            (void)I2C1->SR2;
            I2C1->CR1 |= I2C_CR1_STOP;
            return is_free();
        }
        if (!is_free())
            return false;
    }
    trouble = "stays busy";
    return false;
}

static bool write(unsigned way, uint8_t address, uint8_t *data, uint32_t count)
{
    if (way == 1)
        return by_interrupt(false, address, data, count);
    return way == 2 ? write_by_dma(address, data, count) : write_polled(address, data, count);
}

static bool read(unsigned way, uint8_t address, uint8_t *data, uint32_t count)
{
    if (way == 1)
        return by_interrupt(true, address, data, count);
    return way == 2 ? read_by_dma(address, data, count) : read_polled(address, data, count);
}

static bool try_way(unsigned way)
{
    uint8_t address = (uint8_t)(16 * way + 8), out[PAGE], in[PAGE];
    for (uint32_t at = 0; at < PAGE; ++at)
        out[at] = (uint8_t)(0x11 * (at + 1) + way);
    if (!write(way, address, out, PAGE) || !answers_again())
        return false;
    for (uint32_t count = way == 2 ? 2 : 1; count <= PAGE; ++count) {
        if (!read(way, address, in, count))
            return false;
        for (uint32_t at = 0; at < count; ++at)
            if (in[at] != out[at]) {
                trouble = "differs";
                return false;
            }
    }
    return true;
}

int main(void)
{
    static const char *const names[] = {"polled: ", "by interrupt: ", "by dma: "};
    clock_72mhz();
    cycles_start();
    RCC->AHBENR |= RCC_AHB_DMA1;
    RCC->APB1ENR |= RCC_APB1_I2C1;
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_GPIOB | RCC_APB2_GPIOC | RCC_APB2_USART1;
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    pin_mode(GPIOB, 6, PIN_ALTERNATE_OPEN_DRAIN);
    pin_mode(GPIOB, 7, PIN_ALTERNATE_OPEN_DRAIN);
    pin_write(GPIOC, LED, true);
    pin_mode(GPIOC, LED, PIN_OUTPUT);
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE;
    I2C1->CR2 = 36;
    I2C1->CCR = I2C_CCR_FAST | 30; // 36 MHz / (3 x 30)
    I2C1->TRISE = 36 * 300 / 1000 + 1;
    I2C1->CR1 = I2C_CR1_PE;
    irq_line_enable(I2C1_EV_IRQ);
    irq_line_enable(I2C1_ER_IRQ);
    bool good = true;
    for (unsigned way = 0; way < 3 && good; ++way) {
        good = try_way(way);
        send(names[way]);
        send(good ? "ok" : trouble);
        send("\r\n");
    }
    pin_write(GPIOC, LED, !good);
    for (;;)
        WFI();
}
