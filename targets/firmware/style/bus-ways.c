// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: drivers that trust no bus. Four bytes of a slave on I2C1 (PB6, PB7) at 400 kHz, from a register on, and the
// identification of a flash on SPI1 (PA5 to PA7, chip select PB0) are read polled, by interrupts and by DMA; each wait has a
// limit, and everything that can go wrong is an answer. NSS (PA4) is an input: low, it says that there is another master. All
// of that is done twice, 50 ms apart, so that the second time shows whether the driver has recovered. USART1 (PA9), 115200
// 8N1, says what was found. Who sets `settings` before the start chooses slave, register and mode; else it is a 24C02.

#include "chip/i2c.h"
#include "chip/spi.h"
#include "chip/stm32f103.h"
#include "clock.h"
#include "cycles.h"
#include "handlers.h"
#include "pin.h"

#define BAUD 115200u
#define COUNT 4u
#define LIMIT (72000u * 5u) // 5 ms
#define PAUSE (72000u * 50u)
#define SETTINGS_SET 0x5E77196Eu
#define CS 0
#define NSS 4
#define BERR (1u << 8)
#define ERRORS (I2C_SR1_AF | I2C_SR1_ARLO | BERR)

enum way { POLLED, BY_INTERRUPT, BY_DMA, WAYS };
static const char *const way_names[] = {"polled: ", "by interrupt: ", "by dma: "};

__attribute__((section(".noinit"))) struct {
    uint32_t set;
    uint8_t address, first, spi_mode, reserved;
} settings;

static const char *volatile trouble;
static uint8_t found[COUNT];

static void send(char byte)
{
    while (!(USART1->SR & USART_SR_TXE)) {
    }
    USART1->DR = (uint8_t)byte;
}

static void send_text(const char *text)
{
    for (; *text; ++text)
        send(*text);
}

static bool is_late(uint32_t begin) { return cycles() - begin > LIMIT; }

static void channel(unsigned number, volatile uint32_t *port, const uint8_t *memory, uint32_t more)
{
    DMA1->IFCR = DMA_GIF(number);
    DMA1_CHANNEL(number)->CCR = 0;
    DMA1_CHANNEL(number)->CPAR = (uint32_t)(uintptr_t)port;
    DMA1_CHANNEL(number)->CMAR = (uint32_t)(uintptr_t)memory;
    DMA1_CHANNEL(number)->CNDTR = COUNT;
    DMA1_CHANNEL(number)->CCR = DMA_CCR_MINC | more | DMA_CCR_EN;
}

// --- I2C

static void set_up_i2c(void)
{
    I2C1->CR1 = I2C_CR1_SWRST;
    I2C1->CR1 = 0;
    I2C1->CR2 = 36;
    I2C1->CCR = I2C_CCR_FAST | 30; // 36 MHz / (3 x 30)
    I2C1->TRISE = 36 * 300 / 1000 + 1;
    I2C1->CR1 = I2C_CR1_PE;
}

// Says what is wrong, if anything is; the bus is let go of.
static bool has_failed(uint32_t status)
{
    if (!(status & ERRORS))
        return false;
    trouble = status & I2C_SR1_AF ? "no acknowledge" : status & I2C_SR1_ARLO ? "arbitration lost" : "bus error";
    I2C1->SR1 = 0;
    I2C1->CR1 |= I2C_CR1_STOP;
    return true;
}

static bool event(uint32_t flags)
{
    for (uint32_t begin = cycles(); !is_late(begin);) {
        uint32_t status = I2C1->SR1;
        if ((status & flags) == flags)
            return true;
        if (has_failed(status))
            return false;
    }
    trouble = "no event";
    return false;
}

static bool is_free(void)
{
    for (uint32_t begin = cycles(); I2C1->SR2 & I2C_SR2_BUSY;)
        if (is_late(begin)) {
            trouble = "bus busy";
            return false;
        }
    return true;
}

static bool address(uint32_t direction)
{
    I2C1->CR1 |= I2C_CR1_START | I2C_CR1_ACK;
    if (!event(I2C_SR1_SB))
        return false;
    I2C1->DR = (uint32_t)settings.address << 1 | direction;
    return event(I2C_SR1_ADDR);
}

static bool begin_reading(void)
{
    if (!address(0))
        return false;
    (void)I2C1->SR2;
    I2C1->DR = settings.first;
    return event(I2C_SR1_BTF) && address(1);
}

static bool i2c_polled(void)
{
    if (!begin_reading())
        return false;
    (void)I2C1->SR2;
    if (!event(I2C_SR1_RXNE))
        return false;
    found[0] = (uint8_t)I2C1->DR;
    if (!event(I2C_SR1_BTF))
        return false;
    I2C1->CR1 &= ~I2C_CR1_ACK;
    found[1] = (uint8_t)I2C1->DR;
    if (!event(I2C_SR1_BTF))
        return false;
    I2C1->CR1 |= I2C_CR1_STOP;
    found[2] = (uint8_t)I2C1->DR;
    if (!event(I2C_SR1_RXNE))
        return false;
    found[3] = (uint8_t)I2C1->DR;
    return true;
}

static volatile uint32_t taken;
static volatile bool placed, over;

void I2C1_EV_IRQHandler(void)
{
    uint32_t status = I2C1->SR1;
    if (status & I2C_SR1_SB) {
        I2C1->DR = (uint32_t)settings.address << 1 | placed;
    } else if (status & I2C_SR1_ADDR) {
        (void)I2C1->SR2;
        if (!placed)
            I2C1->DR = settings.first;
    } else if (status & I2C_SR1_RXNE) {
        found[taken++] = (uint8_t)I2C1->DR;
        if (taken == COUNT - 1)
            I2C1->CR1 = (I2C1->CR1 & ~I2C_CR1_ACK) | I2C_CR1_STOP;
        over = taken == COUNT;
    } else if (status & I2C_SR1_BTF && !placed) {
        placed = true;
        I2C1->CR1 |= I2C_CR1_START | I2C_CR1_ACK;
    }
    if (placed && status & I2C_SR1_ADDR)
        I2C1->CR2 |= I2C_CR2_ITBUFEN;
}

void I2C1_ER_IRQHandler(void)
{
    over = has_failed(I2C1->SR1);
}

static bool i2c_by_interrupt(void)
{
    taken = 0;
    placed = over = false;
    I2C1->CR2 |= I2C_CR2_ITEVTEN | I2C_CR2_ITERREN;
    I2C1->CR1 |= I2C_CR1_START | I2C_CR1_ACK;
    for (uint32_t begin = cycles(); !over && !trouble;)
        if (is_late(begin))
            trouble = "no event";
    I2C1->CR2 &= ~(I2C_CR2_ITEVTEN | I2C_CR2_ITERREN | I2C_CR2_ITBUFEN);
    return !trouble;
}

static bool i2c_by_dma(void)
{
    if (!begin_reading())
        return false;
    channel(DMA_I2C1_RX, &I2C1->DR, found, 0);
    I2C1->CR2 |= I2C_CR2_DMAEN | I2C_CR2_LAST;
    (void)I2C1->SR2;
    for (uint32_t begin = cycles(); !(DMA1->ISR & DMA_TCIF(DMA_I2C1_RX)) && !has_failed(I2C1->SR1);)
        if (is_late(begin)) {
            trouble = "no event";
            break;
        }
    I2C1->CR1 |= I2C_CR1_STOP;
    I2C1->CR2 &= ~(I2C_CR2_DMAEN | I2C_CR2_LAST);
    return !trouble;
}

static bool read_i2c(enum way way)
{
    set_up_i2c();
    if (!is_free())
        return false;
    bool good = way == POLLED ? i2c_polled() : way == BY_INTERRUPT ? i2c_by_interrupt() : i2c_by_dma();
    return good && is_free();
}

// --- SPI

static const uint8_t identify[COUNT] = {0x9F, 0xFF, 0xFF, 0xFF};

static bool spi_failed(void)
{
    if (!(SPI1->SR & (SPI_SR_MODF | SPI_SR_OVR)))
        return false;
    trouble = SPI1->SR & SPI_SR_MODF ? "mode fault" : "overrun";
    return true;
}

static bool spi_flag(uint32_t flag)
{
    for (uint32_t begin = cycles(); !(SPI1->SR & flag);)
        if (spi_failed())
            return false;
        else if (is_late(begin)) {
            trouble = "no event";
            return false;
        }
    return !spi_failed();
}

static bool spi_polled(void)
{
    for (taken = 0; taken < COUNT; ++taken) {
        if (!spi_flag(SPI_SR_TXE))
            return false;
        SPI1->DR = identify[taken];
        if (!spi_flag(SPI_SR_RXNE))
            return false;
        found[taken] = (uint8_t)SPI1->DR;
    }
    return true;
}

void SPI1_IRQHandler(void)
{
    if (spi_failed()) {
        SPI1->CR2 = 0;
        return;
    }
    found[taken++] = (uint8_t)SPI1->DR;
    if (taken < COUNT)
        SPI1->DR = identify[taken];
    else
        SPI1->CR2 = 0;
}

static bool spi_by_interrupt(void)
{
    taken = 0;
    SPI1->CR2 = SPI_CR2_RXNEIE | SPI_CR2_ERRIE;
    if (!trouble)
        SPI1->DR = identify[0];
    for (uint32_t begin = cycles(); taken < COUNT && !trouble;)
        if (is_late(begin))
            trouble = "no event";
    return !trouble;
}

static bool spi_by_dma(void)
{
    channel(DMA_SPI1_RX, &SPI1->DR, found, 0);
    channel(DMA_SPI1_TX, &SPI1->DR, identify, DMA_CCR_FROM_MEMORY);
    SPI1->CR2 = SPI_CR2_RXDMAEN | SPI_CR2_TXDMAEN;
    for (uint32_t begin = cycles(); !(DMA1->ISR & DMA_TCIF(DMA_SPI1_RX)) && !spi_failed();)
        if (is_late(begin)) {
            trouble = "no event";
            break;
        }
    SPI1->CR2 = 0;
    return !trouble;
}

static bool read_spi(enum way way)
{
    RCC->APB2RSTR = RCC_APB2_SPI1;
    RCC->APB2RSTR = 0;
    SPI1->CR1 = SPI_CR1_MSTR | 2u << SPI_CR1_BR_SHIFT | settings.spi_mode;
    SPI1->CR1 |= SPI_CR1_SPE;
    pin_write(GPIOB, CS, false);
    bool good = way == POLLED ? spi_polled() : way == BY_INTERRUPT ? spi_by_interrupt() : spi_by_dma();
    pin_write(GPIOB, CS, true);
    return good;
}

// --- What is said of it

static void tell(const char *bus, enum way way, bool good)
{
    static const char digits[] = "0123456789abcdef";
    send_text(bus);
    send_text(way_names[way]);
    if (!good)
        send_text(trouble);
    for (uint32_t at = 0; good && at < COUNT; ++at) {
        send(digits[found[at] >> 4]);
        send(digits[found[at] & 15]);
    }
    send_text("\r\n");
}

int main(void)
{
    clock_72mhz();
    cycles_start();
    if (settings.set != SETTINGS_SET) {
        settings.address = 0x50;
        settings.first = settings.spi_mode = 0;
    }
    RCC->AHBENR |= RCC_AHB_DMA1;
    RCC->APB1ENR |= RCC_APB1_I2C1;
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_GPIOB | RCC_APB2_USART1 | RCC_APB2_SPI1;
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    pin_pull(GPIOA, NSS, true);
    pin_mode(GPIOA, 5, PIN_ALTERNATE);
    pin_mode(GPIOA, 7, PIN_ALTERNATE);
    pin_write(GPIOB, CS, true);
    pin_mode(GPIOB, CS, PIN_OUTPUT);
    pin_mode(GPIOB, 6, PIN_ALTERNATE_OPEN_DRAIN);
    pin_mode(GPIOB, 7, PIN_ALTERNATE_OPEN_DRAIN);
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE;
    irq_line_enable(I2C1_EV_IRQ);
    irq_line_enable(I2C1_ER_IRQ);
    irq_line_enable(SPI1_IRQ);
    uint32_t begin = cycles();
    for (unsigned round = 0; round < 2; ++round) {
        for (enum way way = POLLED; way < WAYS; ++way) {
            trouble = 0;
            tell("i2c ", way, read_i2c(way));
        }
        for (enum way way = POLLED; way < WAYS; ++way) {
            trouble = 0;
            tell("spi ", way, read_spi(way));
        }
        begin = wait_cycles_from(begin, PAUSE);
    }
    for (;;)
        WFI();
}
