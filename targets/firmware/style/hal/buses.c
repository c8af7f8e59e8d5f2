// SPDX-License-Identifier: GPL-2.0-or-later
//
// The same layer with ADC1 (PA0 polled; PA0, PA1 and the reference by DMA), a 24C02 at I2C1 (PB6, PB7, 100 kHz), a W25Q flash at
// SPI1 (chip select PA4, 9 MHz, a page by DMA) and the RTC with an alarm. USART1 (PA9), 115200 8N1, says of each what was found;
// PC13 is lit when all is well.

#include "cycles.h"
#include "hal_buses.h"
#include "handlers.h"
#include "text.h"

#define LED (1u << 13)
#define CS (1u << 4)
#define EEPROM (0x50u << 1)
#define PLACE 0x70u
#define PAGE 8u
#define FLASH_PLACE 0x30u // times 256
#define COUNT 64u
#define TIMEOUT_MS 10u

static hal_uart_t uart = {.instance = USART1, .baud = 115200};
static hal_dma_t adc_dma = {.channel = DMA_ADC1,
                            .settings = DMA_CCR_MINC | 1u << DMA_CCR_PSIZE_SHIFT | 1u << DMA_CCR_MSIZE_SHIFT};
static hal_dma_t spi_rx_dma = {.channel = DMA_SPI1_RX, .settings = DMA_CCR_MINC};
static hal_dma_t spi_tx_dma = {.channel = DMA_SPI1_TX, .settings = DMA_CCR_MINC | DMA_CCR_FROM_MEMORY};
static hal_adc_t adc = {.instance = ADC1, .conversions = 1, .dma = &adc_dma};
static hal_i2c_t i2c = {.instance = I2C1, .hz = 100000};
static hal_spi_t spi = {.instance = SPI1, .divider = 2, .rx_dma = &spi_rx_dma, .tx_dma = &spi_tx_dma};
static volatile uint32_t conversions, alarms;

void SysTick_Handler(void) { hal_inc_tick(); }
void DMA1_Channel1_IRQHandler(void) { hal_dma_irq_handler(&adc_dma); }
void DMA1_Channel2_IRQHandler(void) { hal_dma_irq_handler(&spi_rx_dma); }
void DMA1_Channel3_IRQHandler(void) { hal_dma_irq_handler(&spi_tx_dma); }
void RTCAlarm_IRQHandler(void) { hal_rtc_alarm_irq_handler(); }

void hal_adc_complete_callback(hal_adc_t *which)
{
    (void)which;
    ++conversions;
}

void hal_rtc_alarm_callback(void) { ++alarms; }

void hal_uart_msp_init(hal_uart_t *which)
{
    (void)which;
    RCC->APB2ENR |= RCC_APB2_USART1;
    hal_gpio_init(GPIOA, 1u << 9, PIN_ALTERNATE, false);
}

static bool verdict(struct line *line, bool good)
{
    line_text(line, good ? " ok\r\n" : " wrong\r\n");
    hal_uart_transmit(&uart, (const uint8_t *)line->text, line->length, HAL_FOREVER);
    return good;
}

// --- what is tried

static bool try_adc(void)
{
    static uint16_t samples[3];
    struct line line = EMPTY_LINE;
    bool good = hal_adc_init(&adc) == HAL_OK && hal_adc_calibration_start(&adc) == HAL_OK &&
                hal_adc_config_channel(&adc, 0, 1, 4) == HAL_OK && hal_adc_start(&adc) == HAL_OK &&
                hal_adc_poll_for_conversion(&adc, TIMEOUT_MS) == HAL_OK;
    line_text(&line, "adc ");
    line_decimal(&line, hal_adc_get_value(&adc));
    good = hal_adc_stop(&adc) == HAL_OK && good;
    adc.scan = true;
    adc.conversions = 3;
    good = hal_adc_init(&adc) == HAL_OK && hal_adc_config_channel(&adc, 1, 2, 4) == HAL_OK &&
           hal_adc_config_channel(&adc, ADC_VREFINT, 3, 7) == HAL_OK && hal_adc_start_dma(&adc, samples, 3) == HAL_OK && good;
    for (uint32_t start = hal_get_tick(); !conversions && hal_get_tick() - start < TIMEOUT_MS;) {
    }
    good = hal_adc_stop_dma(&adc) == HAL_OK && conversions == 1 && good;
    for (uint32_t at = 0; at < 3; ++at) {
        line_text(&line, " ");
        line_decimal(&line, samples[at]);
    }
    return verdict(&line, good);
}

static bool try_eeprom(void)
{
    uint8_t out[PAGE], in[PAGE];
    for (uint32_t at = 0; at < PAGE; ++at)
        out[at] = (uint8_t)(0xA0 + 3 * at);
    bool good = hal_i2c_init(&i2c) == HAL_OK && hal_i2c_is_device_ready(&i2c, EEPROM, 3, TIMEOUT_MS) == HAL_OK &&
                hal_i2c_mem_write(&i2c, EEPROM, PLACE, out, PAGE, TIMEOUT_MS) == HAL_OK &&
                hal_i2c_is_device_ready(&i2c, EEPROM, 100, TIMEOUT_MS) == HAL_OK;
    for (uint32_t size = 1; good && size <= PAGE; ++size) {
        good = hal_i2c_mem_read(&i2c, EEPROM, PLACE, in, size, TIMEOUT_MS) == HAL_OK;
        for (uint32_t at = 0; at < size; ++at)
            good = good && in[at] == out[at];
    }
    struct line line = EMPTY_LINE;
    line_text(&line, "eeprom");
    return verdict(&line, good);
}

static bool select(const uint8_t *command, size_t size)
{
    hal_gpio_write(GPIOA, CS, false);
    return hal_spi_transmit(&spi, command, size, TIMEOUT_MS) == HAL_OK;
}

static bool ask(uint8_t command, uint8_t *answer, size_t size)
{
    bool good = select(&command, 1) && (!size || hal_spi_receive(&spi, answer, size, TIMEOUT_MS) == HAL_OK);
    hal_gpio_write(GPIOA, CS, true);
    return good;
}

static bool by_dma(uint8_t command, const uint8_t *out, uint8_t *in)
{
    const uint8_t head[] = {command, 0, FLASH_PLACE, 0};
    bool good = select(head, sizeof head) && hal_spi_transmit_receive_dma(&spi, out, in, COUNT) == HAL_OK;
    for (uint32_t start = hal_get_tick(); spi.state != HAL_STATE_READY && hal_get_tick() - start < TIMEOUT_MS;) {
    }
    hal_gpio_write(GPIOA, CS, true);
    return good && spi.state == HAL_STATE_READY;
}

static bool try_flash(void)
{
    static uint8_t out[COUNT], in[COUNT];
    uint8_t identity[3], status = 1;
    for (uint32_t at = 0; at < COUNT; ++at)
        out[at] = (uint8_t)(at * 13 + 5);
    bool good = hal_spi_init(&spi) == HAL_OK && ask(0x9F, identity, 3) && identity[0] == 0xEF && ask(0x06, 0, 0) &&
                by_dma(0x02, out, in);
    while (good && status & 1)
        good = ask(0x05, &status, 1);
    good = good && by_dma(0x03, out, in);
    for (uint32_t at = 0; at < COUNT; ++at)
        good = good && in[at] == out[at];
    struct line line = EMPTY_LINE;
    line_text(&line, "flash");
    return verdict(&line, good);
}

// A second of 10 ms, by the LSI's 40 kHz.
static bool try_clock(void)
{
    bool good = hal_rtc_init(399) == HAL_OK && hal_rtc_set_time((hal_time_t){23, 59, 58}) == HAL_OK &&
                hal_rtc_set_alarm_it((hal_time_t){23, 59, 59}) == HAL_OK;
    for (uint32_t start = hal_get_tick(); !alarms && hal_get_tick() - start < 100;) {
    }
    hal_delay(1);
    hal_time_t now = hal_rtc_get_time();
    struct line line = EMPTY_LINE;
    line_text(&line, "clock");
    return verdict(&line, good && alarms == 1 && !now.hours && !now.minutes && !now.seconds);
}

static void pins(void)
{
    RCC->CFGR |= 2u << RCC_CFGR_ADCPRE_SHIFT; // 12 MHz
    RCC->AHBENR |= RCC_AHB_DMA1;
    RCC->APB1ENR |= RCC_APB1_I2C1;
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_GPIOB | RCC_APB2_GPIOC | RCC_APB2_ADC1 | RCC_APB2_SPI1;
    hal_gpio_write(GPIOC, LED, true);
    hal_gpio_init(GPIOC, LED, PIN_OUTPUT, false);
    hal_gpio_write(GPIOA, CS, true);
    hal_gpio_init(GPIOA, CS, PIN_OUTPUT, false);
    hal_gpio_init(GPIOA, 1u << 0 | 1u << 1, PIN_ANALOG, false);
    hal_gpio_init(GPIOA, 1u << 5 | 1u << 7, PIN_ALTERNATE, false);
    hal_gpio_init(GPIOA, 1u << 6, PIN_PULLED, true);
    hal_gpio_init(GPIOB, 1u << 6 | 1u << 7, PIN_ALTERNATE_OPEN_DRAIN, false);
    for (unsigned channel = 1; channel <= 3; ++channel)
        irq_line_enable(DMA1_CHANNEL1_IRQ + channel - 1);
    irq_line_enable(RTC_ALARM_IRQ);
}

int main(void)
{
    hal_init();
    hal_clock_config(&(hal_clock_config_t){true, 9, APB_DIV2, 2});
    cycles_start();
    pins();
    hal_uart_init(&uart);
    bool good = try_adc();
    good = try_eeprom() && good;
    good = try_flash() && good;
    good = try_clock() && good;
    hal_gpio_write(GPIOC, LED, !good);
    for (;;)
        WFI();
}
