// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: low-layer drivers, inline functions that access one register each, and a program that knows the manual. PA0,
// PA1 and the reference one after the other by discontinuous mode and EOC interrupts; a 24C02 at I2C1 (PB6, PB7, 400 kHz,
// duty 16/9), whose longer messages DMA carries; a W25Q flash at SPI1 (chip select PA4, 18 MHz) with DR accessed as bytes; the
// RTC on the LSI, whose second interrupts. USART1 (PA9), 115200 8N1, says what was found; PC13 is lit when all is well.

#include "chip/adc.h"
#include "chip/i2c.h"
#include "chip/rtc.h"
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
#define EEPROM 0x50u
#define PLACE 0x88u
#define PAGE 8u
#define FLASH_PLACE 0x50u // times 256
#define COUNT 16u
#define LIMIT (72000u * 10u) // 10 ms

#define SET_BIT(where, bits) ((where) |= (bits))
#define CLEAR_BIT(where, bits) ((where) &= ~(bits))
#define WITHIN(condition)                                                                                               \
    ({                                                                                                                  \
        uint32_t since_ = cycles();                                                                                     \
        bool met_;                                                                                                      \
        while (!(met_ = (condition)) && cycles() - since_ < LIMIT) {                                                    \
        }                                                                                                               \
        met_;                                                                                                           \
    })

static volatile uint32_t readings[3], reading, seconds;

static bool verdict(struct line *line, bool good)
{
    line_text(line, good ? " ok\r\n" : " wrong\r\n");
    for (const char *at = line->text; *at; ++at) {
        while (!(USART1->SR & USART_SR_TXE)) {
        }
        USART1->DR = (uint8_t)*at;
    }
    return good;
}

// --- converter

static inline void adc_enable(void) { SET_BIT(ADC1->CR2, ADC_CR2_ADON); }
static inline void adc_start_calibration(void) { SET_BIT(ADC1->CR2, ADC_CR2_CAL); }
static inline bool adc_calibrates(void) { return ADC1->CR2 & ADC_CR2_CAL; }
static inline void adc_start(void) { SET_BIT(ADC1->CR2, ADC_CR2_SWSTART | ADC_CR2_EXTTRIG); }

void ADC1_2_IRQHandler(void)
{
    ADC1->SR = ~ADC_SR_EOC;
    readings[reading++] = ADC1->DR & 0xFFF;
}

static bool try_adc(void)
{
    ADC1->CR1 = ADC_CR1_SCAN | ADC_CR1_DISCEN | ADC_CR1_EOCIE; // one channel for each start
    ADC1->CR2 = ADC_BY_SOFTWARE << ADC_CR2_EXTSEL_SHIFT | ADC_CR2_TSVREFE;
    ADC1->SQR1 = 2u << 20;
    ADC1->SQR3 = 0u | 1u << 5 | ADC_VREFINT << 10;
    ADC1->SMPR1 = 7u << 21;
    ADC1->SMPR2 = 2u | 2u << 3;
    irq_line_enable(ADC1_2_IRQ);
    adc_enable();
    wait_cycles(72 * 10);
    adc_start_calibration();
    bool good = WITHIN(!adc_calibrates());
    struct line line = EMPTY_LINE;
    line_text(&line, "adc");
    for (uint32_t at = 0; at < 3 && good; ++at) {
        adc_start();
        good = WITHIN(reading > at);
        line_text(&line, " ");
        line_decimal(&line, readings[at]);
    }
    return verdict(&line, good && reading == 3);
}

// --- I2C

static inline void i2c_start(void) { SET_BIT(I2C1->CR1, I2C_CR1_START); }
static inline void i2c_stop(void) { SET_BIT(I2C1->CR1, I2C_CR1_STOP); }
static inline bool i2c_flag(uint32_t flag) { return I2C1->SR1 & flag; }
static inline bool i2c_is_busy(void) { return I2C1->SR2 & I2C_SR2_BUSY; }
static inline void i2c_transmit(uint8_t byte) { I2C1->DR = byte; }
static inline void i2c_clear_addr(void)
{
    (void)I2C1->SR1;
    (void)I2C1->SR2;
}
static inline void i2c_clear_af(void) { CLEAR_BIT(I2C1->SR1, I2C_SR1_AF); }

static bool i2c_address(uint32_t direction)
{
    i2c_start();
    if (!WITHIN(i2c_flag(I2C_SR1_SB)))
        return false;
    i2c_transmit((uint8_t)(EEPROM << 1 | direction));
    WITHIN(i2c_flag(I2C_SR1_ADDR | I2C_SR1_AF));
    if (i2c_flag(I2C_SR1_ADDR))
        return true;
    i2c_clear_af();
    i2c_stop();
    return false;
}

static void dma(unsigned number, volatile uint32_t *peripheral, volatile void *memory, uint32_t count, uint32_t settings)
{
    CLEAR_BIT(DMA1_CHANNEL(number)->CCR, DMA_CCR_EN);
    DMA1->IFCR = DMA_GIF(number);
    DMA1_CHANNEL(number)->CCR = DMA_CCR_MINC | settings;
    DMA1_CHANNEL(number)->CPAR = (uint32_t)(uintptr_t)peripheral;
    DMA1_CHANNEL(number)->CMAR = (uint32_t)(uintptr_t)memory;
    DMA1_CHANNEL(number)->CNDTR = count;
    SET_BIT(DMA1_CHANNEL(number)->CCR, DMA_CCR_EN);
}

static bool dma_is_over(unsigned number) { return WITHIN(DMA1->ISR & DMA_TCIF(number)); }

static bool i2c_answers(void)
{
    while (i2c_is_busy()) {
    }
    if (!i2c_address(0))
        return false;
    i2c_clear_addr();
    i2c_stop();
    return true;
}

static bool i2c_write(uint8_t *data, uint32_t count)
{
    if (!WITHIN(!i2c_is_busy()) || !i2c_address(0))
        return false;
    dma(DMA_I2C1_TX, &I2C1->DR, data, count, DMA_CCR_FROM_MEMORY);
    SET_BIT(I2C1->CR2, I2C_CR2_DMAEN);
    i2c_clear_addr();
    bool good = dma_is_over(DMA_I2C1_TX) && WITHIN(i2c_flag(I2C_SR1_BTF));
    CLEAR_BIT(I2C1->CR2, I2C_CR2_DMAEN);
    i2c_stop();
    return good;
}

// A single byte the program reads itself, and refuses it.
static bool i2c_read(uint8_t place, uint8_t *data, uint32_t count)
{
    if (!WITHIN(!i2c_is_busy()) || !i2c_address(0))
        return false;
    i2c_clear_addr();
    i2c_transmit(place);
    if (!WITHIN(i2c_flag(I2C_SR1_BTF)))
        return false;
    SET_BIT(I2C1->CR1, I2C_CR1_ACK);
    if (!i2c_address(1))
        return false;
    bool good;
    if (count == 1) {
        CLEAR_BIT(I2C1->CR1, I2C_CR1_ACK);
        i2c_clear_addr();
        i2c_stop();
        good = WITHIN(i2c_flag(I2C_SR1_RXNE));
        *data = (uint8_t)I2C1->DR;
    } else {
        dma(DMA_I2C1_RX, &I2C1->DR, data, count, 0);
        SET_BIT(I2C1->CR2, I2C_CR2_LAST | I2C_CR2_DMAEN);
        i2c_clear_addr();
        good = dma_is_over(DMA_I2C1_RX);
        i2c_stop();
        CLEAR_BIT(I2C1->CR2, I2C_CR2_LAST | I2C_CR2_DMAEN);
    }
    return good;
}

static bool try_eeprom(void)
{
    I2C1->CR2 = 36;
    I2C1->CCR = I2C_CCR_FAST | I2C_CCR_DUTY | 4; // 36 MHz / (25 x 4) = 360 kHz
    I2C1->TRISE = 36 * 300 / 1000 + 1;
    SET_BIT(I2C1->CR1, I2C_CR1_PE);
    uint8_t out[1 + PAGE] = {PLACE}, in[PAGE];
    for (uint32_t at = 0; at < PAGE; ++at)
        out[1 + at] = (uint8_t)(0xE0 + 3 * at);
    bool good = i2c_write(out, sizeof out) && WITHIN(i2c_answers());
    for (uint32_t count = 1; good && count <= PAGE; ++count) {
        good = i2c_read(PLACE, in, count);
        for (uint32_t at = 0; at < count; ++at)
            good = good && in[at] == out[1 + at];
    }
    struct line line = EMPTY_LINE;
    line_text(&line, "eeprom");
    return verdict(&line, good);
}

// --- SPI

static inline void spi_transmit8(uint8_t byte) { *(volatile uint8_t *)&SPI1->DR = byte; }
static inline uint8_t spi_receive8(void) { return *(volatile uint8_t *)&SPI1->DR; }
static inline void spi_transmit16(uint16_t word) { *(volatile uint16_t *)&SPI1->DR = word; }
static inline uint16_t spi_receive16(void) { return *(volatile uint16_t *)&SPI1->DR; }
static inline bool spi_flag(uint32_t flag) { return SPI1->SR & flag; }

static uint8_t swap(uint8_t byte)
{
    while (!spi_flag(SPI_SR_TXE)) {
    }
    spi_transmit8(byte);
    while (!spi_flag(SPI_SR_RXNE)) {
    }
    return spi_receive8();
}

static void select(bool selected)
{
    while (spi_flag(SPI_SR_BSY)) {
    }
    pin_write(GPIOA, CS, !selected);
}

static void command(uint8_t code)
{
    select(true);
    swap(code);
}

static void command_at(uint8_t code)
{
    command(code);
    swap(0);
    swap(FLASH_PLACE);
    swap(0);
}

static void set_width(uint32_t dff)
{
    while (spi_flag(SPI_SR_BSY)) {
    }
    CLEAR_BIT(SPI1->CR1, SPI_CR1_SPE);
    SPI1->CR1 = (SPI1->CR1 & ~SPI_CR1_DFF) | dff;
    SET_BIT(SPI1->CR1, SPI_CR1_SPE);
}

static bool flash_is_busy(void)
{
    command(0x05);
    bool busy = swap(0xFF) & 1;
    select(false);
    return busy;
}

static bool try_flash(void)
{
    SPI1->CR1 = SPI_CR1_MSTR | SPI_CR1_SSM | SPI_CR1_SSI | 1u << SPI_CR1_BR_SHIFT;
    SET_BIT(SPI1->CR1, SPI_CR1_SPE);
    command(0x9F);
    bool good = swap(0xFF) == 0xEF;
    select(false);
    if (good) {
        command(0x06);
        select(false);
        command_at(0x02);
        for (uint32_t at = 0; at < COUNT; ++at)
            swap((uint8_t)(at << 4 | (COUNT - 1 - at)));
        select(false);
        good = WITHIN(!flash_is_busy());
    }
    command_at(0x03);
    set_width(SPI_CR1_DFF); // the rest as words, the first byte in the upper half
    for (uint32_t at = 0; at < COUNT && good; at += 2) {
        spi_transmit16(0xFFFF);
        while (!spi_flag(SPI_SR_RXNE)) {
        }
        uint32_t high = at << 4 | (COUNT - 1 - at), low = (at + 1) << 4 | (COUNT - 2 - at);
        good = spi_receive16() == (high << 8 | low);
    }
    select(false);
    set_width(0);
    struct line line = EMPTY_LINE;
    line_text(&line, "flash");
    return verdict(&line, good);
}

// --- real-time clock

static inline bool rtc_flag(uint32_t flag) { return RTC->CRL & flag; }
static inline void rtc_disable_write_protection(void) { SET_BIT(RTC->CRL, RTC_CRL_CNF); }
static inline void rtc_enable_write_protection(void) { CLEAR_BIT(RTC->CRL, RTC_CRL_CNF); }

void RTC_IRQHandler(void)
{
    CLEAR_BIT(RTC->CRL, RTC_CRL_SECF);
    ++seconds;
}

// A second of 10 ms; the LSI has 30 kHz to 60 kHz (DS5319, table 25).
static bool try_clock(void)
{
    SET_BIT(RCC->APB1ENR, RCC_APB1_PWR | RCC_APB1_BKP);
    SET_BIT(PWR->CR, PWR_CR_DBP);
    SET_BIT(RCC->BDCR, RCC_BDCR_BDRST);
    CLEAR_BIT(RCC->BDCR, RCC_BDCR_BDRST);
    SET_BIT(RCC->CSR, RCC_CSR_LSION);
    bool good = WITHIN(RCC->CSR & RCC_CSR_LSIRDY);
    SET_BIT(RCC->BDCR, RCC_BDCR_RTC_LSI);
    SET_BIT(RCC->BDCR, RCC_BDCR_RTC_ON);
    CLEAR_BIT(RTC->CRL, RTC_CRL_RSF);
    good = WITHIN(rtc_flag(RTC_CRL_RSF)) && WITHIN(rtc_flag(RTC_CRL_RTOFF)) && good;
    rtc_disable_write_protection();
    RTC->PRLH = 0;
    RTC->PRLL = 399;
    RTC->CNTH = 0x1234;
    RTC->CNTL = 0xFFFF;
    rtc_enable_write_protection();
    good = WITHIN(rtc_flag(RTC_CRL_RTOFF)) && good;
    CLEAR_BIT(RTC->CRL, RTC_CRL_SECF);
    irq_line_enable(RTC_IRQ);
    SET_BIT(RTC->CRH, RTC_CRL_SECF);
    uint32_t began = cycles();
    while (seconds < 2 && cycles() - began < 5 * LIMIT) {
    }
    uint32_t took = cycles() - began;
    struct line line = EMPTY_LINE;
    line_text(&line, "clock");
    return verdict(&line, good && seconds == 2 && RTC->CNTH == 0x1235 && took > LIMIT && took < 3 * LIMIT);
}

int main(void)
{
    clock_72mhz();
    cycles_start();
    RCC->CFGR |= 2u << RCC_CFGR_ADCPRE_SHIFT; // 12 MHz
    RCC->AHBENR |= RCC_AHB_DMA1;
    RCC->APB1ENR |= RCC_APB1_I2C1;
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_GPIOB | RCC_APB2_GPIOC | RCC_APB2_ADC1 | RCC_APB2_SPI1 | RCC_APB2_USART1;
    pin_write(GPIOC, LED, true);
    pin_mode(GPIOC, LED, PIN_OUTPUT);
    pin_write(GPIOA, CS, true);
    pin_mode(GPIOA, CS, PIN_OUTPUT);
    pin_mode(GPIOA, 0, PIN_ANALOG);
    pin_mode(GPIOA, 1, PIN_ANALOG);
    pin_mode(GPIOA, 5, PIN_ALTERNATE);
    pin_pull(GPIOA, 6, true);
    pin_mode(GPIOA, 7, PIN_ALTERNATE);
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    pin_mode(GPIOB, 6, PIN_ALTERNATE_OPEN_DRAIN);
    pin_mode(GPIOB, 7, PIN_ALTERNATE_OPEN_DRAIN);
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE;
    bool good = try_adc();
    good = try_eeprom() && good;
    good = try_flash() && good;
    good = try_clock() && good;
    pin_write(GPIOC, LED, !good);
    for (;;)
        WFI();
}
