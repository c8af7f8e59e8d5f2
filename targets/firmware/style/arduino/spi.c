// SPDX-License-Identifier: GPL-2.0-or-later
//
// SPI1 (PA5 to PA7). A transaction switches it off, sets it and switches it on. A word is over when TXE is set and BSY is not;
// RXNE is never asked. A length of word of its own is for transfer16 alone.

#include "chip/spi.h"

#include "arduino.h"
#include "chip/stm32f103.h"
#include "clock.h"

void SPI_begin(void)
{
    RCC->APB2ENR |= RCC_APB2_SPI1;
    pinMode(PA5, ALTERNATE);
    pinMode(PA6, INPUT_PULLUP);
    pinMode(PA7, ALTERNATE);
}

void SPI_beginTransaction(struct spi_settings settings)
{
    uint32_t divider = 0;
    while (divider < 7 && clock_pclk2_hz() >> (divider + 1) > settings.hz)
        ++divider;
    SPI1->CR1 &= ~SPI_CR1_SPE;
    SPI1->CR1 = SPI_CR1_MSTR | SPI_CR1_SSM | SPI_CR1_SSI | divider << SPI_CR1_BR_SHIFT | settings.mode;
    *bit_of(&SPI1->CR1, 6) = 1; // SPE
}

static void wait_for_end(void)
{
    while (!(SPI1->SR & SPI_SR_TXE)) {
    }
    while (SPI1->SR & SPI_SR_BSY) {
    }
}

void SPI_endTransaction(void)
{
    wait_for_end();
    *bit_of(&SPI1->CR1, 6) = 0;
}

static uint16_t transfer(uint16_t word)
{
    (void)SPI1->DR; // whatever is left there
    SPI1->DR = word;
    wait_for_end();
    return (uint16_t)SPI1->DR;
}

uint8_t SPI_transfer(uint8_t byte) { return (uint8_t)transfer(byte); }

static void set_length(uint32_t dff)
{
    SPI1->CR1 &= ~SPI_CR1_SPE;
    SPI1->CR1 = (SPI1->CR1 & ~SPI_CR1_DFF) | dff;
    SPI1->CR1 |= SPI_CR1_SPE;
}

uint16_t SPI_transfer16(uint16_t word)
{
    set_length(SPI_CR1_DFF);
    word = transfer(word);
    set_length(0);
    return word;
}

void SPI_write(const uint8_t *data, uint32_t count)
{
    for (; count; --count) {
        while (!(SPI1->SR & SPI_SR_TXE)) {
        }
        SPI1->DR = *data++;
    }
    wait_for_end();
    (void)SPI1->DR; // an overrun ends with DR and SR (RM0008, 25.3.10)
    (void)SPI1->SR;
}
