// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: an I2C of two port pins, as libraries without an interface have it, at some 100 kHz. A page of a 24C02
// at PB6 (SCL) and PB7 (SDA) is written and read bit by bit. Then I2C1 takes the pins over, is switched off in the middle
// of a byte, and finds SDA low: the bus is freed by clocks (UM10204, section 3.1.16), and I2C1 reads the page. USART1 (PA9),
// 115200 8N1, says what was found; PC13 is lit when all is well.

#include "chip/i2c.h"
#include "chip/stm32f103.h"
#include "clock.h"
#include "cycles.h"
#include "pin.h"

#define BAUD 115200u
#define LED 13
#define SCL 6
#define SDA 7
#define EEPROM 0x50u
#define PAGE 8u
#define HALF (72u * 5u) // 5 us
#define LIMIT (72000u * 10u)

static void send(const char *text)
{
    for (; *text; ++text) {
        while (!(USART1->SR & USART_SR_TXE)) {
        }
        USART1->DR = (uint8_t)*text;
    }
}

static void wait(void)
{
    for (uint32_t begin = cycles(); cycles() - begin < HALF;) {
    }
}

// --- Bits

static void line(unsigned pin, bool high)
{
    GPIOB->BSRR = high ? 1u << pin : 1u << (pin + 16);
    wait();
}

static bool level(unsigned pin)
{
    return GPIOB->IDR >> pin & 1;
}

static void clock_up(void)
{
    line(SCL, true);
    for (uint32_t begin = cycles(); !level(SCL) && cycles() - begin < LIMIT;) {
    }
}

static bool bit(bool out)
{
    line(SDA, out);
    clock_up();
    bool in = level(SDA);
    line(SCL, false);
    return in;
}

static void begin_bits(void)
{
    line(SDA, true);
    clock_up();
    line(SDA, false);
    line(SCL, false);
}

static void end_bits(void)
{
    line(SDA, false);
    clock_up();
    line(SDA, true);
}

static bool send_byte(uint8_t byte)
{
    for (int at = 7; at >= 0; --at)
        bit(byte >> at & 1);
    return !bit(true);
}

static uint8_t receive_byte(bool acknowledge)
{
    uint32_t byte = 0;
    for (int at = 0; at < 8; ++at)
        byte = byte << 1 | bit(true);
    bit(!acknowledge);
    return (uint8_t)byte;
}

static bool answers(void)
{
    for (uint32_t begin = cycles(); cycles() - begin < LIMIT;) {
        begin_bits();
        bool there = send_byte(EEPROM << 1);
        end_bits();
        if (there)
            return true;
    }
    return false;
}

static bool page_by_bits(void)
{
    begin_bits();
    bool good = send_byte(EEPROM << 1) && send_byte(0x20);
    for (uint32_t at = 0; good && at < PAGE; ++at)
        good = send_byte((uint8_t)(at * 3));
    end_bits();
    if (!good || !answers())
        return false;
    begin_bits();
    good = send_byte(EEPROM << 1) && send_byte(0x20);
    begin_bits();
    good = good && send_byte(EEPROM << 1 | 1);
    for (uint32_t at = 0; good && at < PAGE; ++at)
        good = receive_byte(at + 1 < PAGE) == at * 3;
    end_bits();
    return good;
}

// --- I2C1

static bool event(uint32_t flag)
{
    for (uint32_t begin = cycles(); cycles() - begin < LIMIT;)
        if (I2C1->SR1 & flag)
            return true;
    return false;
}

static void interface_on(void)
{
    pin_mode(GPIOB, SCL, PIN_ALTERNATE_OPEN_DRAIN);
    pin_mode(GPIOB, SDA, PIN_ALTERNATE_OPEN_DRAIN);
    I2C1->CR1 = I2C_CR1_SWRST;
    I2C1->CR1 = 0;
    I2C1->CR2 = 36;
    I2C1->CCR = 180; // 36 MHz / (2 x 180)
    I2C1->TRISE = 37;
    I2C1->CR1 = I2C_CR1_PE;
}

static void pins_on(void)
{
    I2C1->CR1 = 0;
    GPIOB->BSRR = 1u << SCL | 1u << SDA;
    pin_mode(GPIOB, SCL, PIN_OUTPUT_OPEN_DRAIN);
    pin_mode(GPIOB, SDA, PIN_OUTPUT_OPEN_DRAIN);
    wait();
}

static bool begin(uint32_t direction)
{
    I2C1->CR1 |= I2C_CR1_START | I2C_CR1_ACK;
    if (!event(I2C_SR1_SB))
        return false;
    I2C1->DR = EEPROM << 1 | direction;
    if (!event(I2C_SR1_ADDR))
        return false;
    (void)I2C1->SR2;
    return true;
}

static bool begin_reading(void)
{
    if (!begin(0))
        return false;
    I2C1->DR = 0x20;
    return event(I2C_SR1_BTF) && begin(1);
}

static bool page_by_interface(void)
{
    bool good = begin_reading();
    for (uint32_t at = 0; good && at < PAGE; ++at) {
        if (at + 1 == PAGE)
            I2C1->CR1 = (I2C1->CR1 & ~I2C_CR1_ACK) | I2C_CR1_STOP;
        good = event(I2C_SR1_RXNE) && I2C1->DR == at * 3;
    }
    return good;
}

int main(void)
{
    clock_72mhz();
    cycles_start();
    RCC->APB1ENR |= RCC_APB1_I2C1;
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_GPIOB | RCC_APB2_GPIOC | RCC_APB2_USART1;
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    pin_write(GPIOC, LED, true);
    pin_mode(GPIOC, LED, PIN_OUTPUT);
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE;

    pins_on();
    bool good = page_by_bits();
    send(good ? "bits: ok\r\n" : "bits: failed\r\n");

    interface_on();
    good = begin_reading() && good;
    for (int at = 0; at < 6; ++at) // into the fourth bit of the first byte, which is 0
        wait();
    pins_on();
    send(level(SDA) ? "SDA is free\r\n" : "SDA is held low\r\n");
    interface_on();
    send(I2C1->SR2 & I2C_SR2_BUSY ? "I2C1 is busy\r\n" : "I2C1 is free\r\n");
    pins_on();
    uint32_t clocks = 0;
    for (; clocks < 9 && !level(SDA); ++clocks)
        bit(true);
    char text[] = "freed after 0 clocks\r\n";
    text[12] = (char)('0' + clocks);
    send(text);
    begin_bits();
    end_bits();

    interface_on();
    bool read = page_by_interface();
    send(read ? "I2C1: ok\r\n" : "I2C1: failed\r\n");
    pin_write(GPIOC, LED, !(good && read));
    for (;;)
        WFI();
}
