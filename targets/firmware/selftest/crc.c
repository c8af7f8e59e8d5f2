// SPDX-License-Identifier: GPL-2.0-or-later
//
// CRC calculation unit (RM0008, section 4): CRC-32 with the polynomial 0x04C11DB7, the first bit the highest, whole words.

#include "check.h"
#include "chip/stm32f103.h"

static uint32_t by_hand(uint32_t crc, uint32_t word)
{
    crc ^= word;
    for (int bit = 0; bit < 32; ++bit)
        crc = crc & 0x80000000u ? crc << 1 ^ 0x04C11DB7u : crc << 1;
    return crc;
}

static uint32_t differences(void)
{
    uint32_t want = 0xFFFFFFFFu, wrong = 0, word = 1;
    CRC->CR = CRC_CR_RESET;
    for (int i = 0; i < 256; ++i) {
        word = word * 1664525u + 1013904223u;
        CRC->DR = word;
        want = by_hand(want, word);
        wrong += CRC->DR != want;
    }
    return wrong;
}

int main(void)
{
    RCC->AHBENR |= RCC_AHB_CRC;
    check_equal("dr-reset", CRC->DR, 0xFFFFFFFF);
    check_equal("idr-reset", CRC->IDR, 0);
    CRC->DR = 0x12345678;
    check_equal("one-word", CRC->DR, 0xDF8A8A2B);
    CRC->IDR = 0x1A5;
    check_equal("idr-has-8-bits", CRC->IDR, 0xA5);
    CRC->CR = CRC_CR_RESET;
    check_equal("reset-bit", CRC->DR, 0xFFFFFFFF);
    check_equal("reset-bit-reads-0", CRC->CR, 0);
    check_equal("idr-survives-reset-bit", CRC->IDR, 0xA5);
    CRC->DR = 0;
    check_equal("of-zero", CRC->DR, 0xC704DD7B);
    check_equal("of-256-words", differences(), 0);
    RCC->AHBENR &= ~RCC_AHB_CRC;
    RCC->AHBENR |= RCC_AHB_CRC;
    check_equal("idr-survives-gate", CRC->IDR, 0xA5);
    check_done();
}
