// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: a program on libopencm3. PA0, the reference and the sensor by ADC1; a 24C02 at I2C1 (PB6, PB7), 400 kHz; a
// W25Q flash at SPI1 (PA5 to PA7, chip select PA4), 9 MHz; the RTC on the LSI with an interrupt each 10 ms. USART1 (PA9),
// 115200 8N1, says of each what was found; PC13 is lit when all is well.

#include "opencm3.h"
#include "text.h"

#define LED (1u << 13)
#define CS (1u << 4)
#define EEPROM 0x50u
#define PLACE 0x20u
#define FLASH_PLACE 0x4000u
#define COUNT 8u
#define LIMIT_MS 20u
#define TICKS 3u

static volatile uint32_t system_millis, ticks, injected[2], injected_ends;

void sys_tick_handler(void) { ++system_millis; }

void rtc_isr(void)
{
    rtc_clear_flag(RTC_CRL_SECF);
    ++ticks;
}

void adc1_2_isr(void)
{
    injected[0] = adc_read_injected(ADC1, 1);
    injected[1] = adc_read_injected(ADC1, 2);
    ADC1->SR &= ~ADC_SR_JEOC;
    ++injected_ends;
}

static void put_string(const char *text)
{
    while (*text)
        usart_send_blocking(USART1, (uint8_t)*text++);
}

static bool verdict(const char *what, bool good)
{
    put_string(what);
    put_string(good ? " ok\r\n" : " wrong\r\n");
    return good;
}

static bool within(uint32_t since, uint32_t limit_ms) { return system_millis - since < limit_ms; }

// --- set up

static void clock_setup(void)
{
    rcc_clock_setup_in_hse_8mhz_out_72mhz();
    rcc_periph_clock_enable(RCC_GATE_GPIOA);
    rcc_periph_clock_enable(RCC_GATE_GPIOB);
    rcc_periph_clock_enable(RCC_GATE_GPIOC);
    rcc_periph_clock_enable(RCC_GATE_USART1);
    rcc_periph_clock_enable(RCC_GATE_ADC1);
    rcc_periph_clock_enable(RCC_GATE_SPI1);
    rcc_periph_clock_enable(RCC_GATE_I2C1);
    systick_set_clocksource(SYSTICK_CLKSOURCE);
    systick_set_reload(rcc_ahb_frequency / 1000 - 1);
    systick_interrupt_enable();
    systick_counter_enable();
}

static void gpio_setup(void)
{
    gpio_set(GPIOC, LED);
    gpio_set_mode(GPIOC, GPIO_MODE_OUTPUT_2_MHZ, GPIO_CNF_OUTPUT_PUSHPULL, LED);
    gpio_set(GPIOA, CS);
    gpio_set_mode(GPIOA, GPIO_MODE_OUTPUT_50_MHZ, GPIO_CNF_OUTPUT_PUSHPULL, CS);
    gpio_set_mode(GPIOA, GPIO_MODE_OUTPUT_50_MHZ, GPIO_CNF_OUTPUT_ALTFN_PUSHPULL, 1u << 5 | 1u << 7 | 1u << 9);
    gpio_set_mode(GPIOA, GPIO_MODE_INPUT, GPIO_CNF_INPUT_PULL_UPDOWN, 1u << 6);
    gpio_set(GPIOA, 1u << 6);
    gpio_set_mode(GPIOA, GPIO_MODE_INPUT, GPIO_CNF_INPUT_ANALOG, 1u << 0);
    gpio_set_mode(GPIOB, GPIO_MODE_OUTPUT_50_MHZ, GPIO_CNF_OUTPUT_ALTFN_OPENDRAIN, 1u << 6 | 1u << 7);
}

static void usart_setup(void)
{
    usart_set_baudrate(USART1, 115200);
    usart_set_databits(USART1, 8);
    usart_set_stopbits(USART1, 0);
    usart_set_mode(USART1, USART_CR1_TE);
    usart_set_parity(USART1, 0);
    usart_set_flow_control(USART1, 0);
    usart_enable(USART1);
}

static void adc_setup(void)
{
    adc_power_off(ADC1);
    adc_disable_scan_mode(ADC1);
    adc_set_single_conversion_mode(ADC1);
    adc_disable_external_trigger_regular(ADC1);
    adc_set_right_aligned(ADC1);
    adc_enable_temperature_sensor(ADC1);
    adc_set_sample_time_on_all_channels(ADC1, ADC_SMPR_239DOT5CYC);
    adc_power_on(ADC1);
    for (uint32_t wait = 0; wait < 800; ++wait)
        NOP();
    adc_reset_calibration(ADC1);
    adc_calibrate(ADC1);
}

static void i2c_setup(void)
{
    rcc_periph_reset_pulse(RCC_GATE_I2C1);
    i2c_peripheral_disable(I2C1);
    i2c_set_clock_frequency(I2C1, 36);
    i2c_set_fast_mode(I2C1);
    i2c_set_ccr(I2C1, 0x1E);
    i2c_set_trise(I2C1, 0x0B);
    i2c_set_own_7bit_slave_address(I2C1, 0x32);
    i2c_peripheral_enable(I2C1);
}

static void spi_setup(void)
{
    rcc_periph_reset_pulse(RCC_GATE_SPI1);
    spi_init_master(SPI1, SPI_BAUDRATE_FPCLK_DIV_8, SPI_CLOCK_IDLE_LOW, SPI_CLOCK_FIRST_TRANSITION, SPI_DFF_8BIT, SPI_MSBFIRST);
    spi_enable_software_slave_management(SPI1);
    spi_set_nss_high(SPI1);
    spi_enable(SPI1);
}

// --- what is tried

static uint32_t read_adc(uint8_t channel)
{
    adc_set_regular_sequence(ADC1, 1, &channel);
    adc_start_conversion_direct(ADC1);
    while (!adc_eoc(ADC1)) {
    }
    return adc_read_regular(ADC1);
}

static bool try_adc(void)
{
    static const uint8_t inner[] = {ADC_VREFINT, ADC_SENSOR};
    struct line line = EMPTY_LINE;
    line_text(&line, "adc: PA0 ");
    line_decimal(&line, read_adc(0));
    adc_enable_scan_mode(ADC1);
    adc_set_injected_sequence(ADC1, 2, inner);
    adc_enable_external_trigger_injected(ADC1, ADC_BY_SOFTWARE);
    adc_enable_eoc_interrupt_injected(ADC1);
    nvic_enable_irq(ADC1_2_IRQ);
    adc_start_conversion_injected(ADC1);
    while (!injected_ends) {
    }
    uint32_t supply_mv = 1200u * 4095u / injected[0];
    line_text(&line, " supply ");
    line_decimal(&line, supply_mv);
    line_text(&line, " mV, sensor ");
    line_decimal(&line, injected[1]);
    return verdict(line.text, supply_mv > 2400 && supply_mv < 3600);
}

// The driver would wait for ever: whether an address is acknowledged the program has to see for itself.
static bool answers(void)
{
    uint32_t since = system_millis;
    do {
        while (I2C1->SR2 & I2C_SR2_BUSY) {
        }
        i2c_send_start(I2C1);
        while (!(I2C1->SR1 & I2C_SR1_SB)) {
        }
        i2c_send_7bit_address(I2C1, EEPROM, I2C_WRITE);
        uint32_t status;
        while (!((status = I2C1->SR1) & (I2C_SR1_ADDR | I2C_SR1_AF))) {
        }
        (void)I2C1->SR2;
        i2c_send_stop(I2C1);
        if (status & I2C_SR1_ADDR)
            return true;
        I2C1->SR1 &= ~I2C_SR1_AF;
    } while (within(since, LIMIT_MS));
    return false;
}

static bool try_i2c(void)
{
    uint8_t out[1 + COUNT] = {PLACE}, in[COUNT];
    for (uint32_t at = 0; at < COUNT; ++at)
        out[1 + at] = (uint8_t)(0xC3 + 7 * at);
    bool good = answers();
    if (good) {
        i2c_transfer7(I2C1, EEPROM, out, sizeof out, 0, 0);
        good = answers();
    }
    for (uint32_t count = 1; good && count <= COUNT; ++count) {
        i2c_transfer7(I2C1, EEPROM, out, 1, in, count);
        for (uint32_t at = 0; at < count; ++at)
            good = good && in[at] == out[1 + at];
    }
    return verdict("i2c:", good);
}

static void flash_command(uint8_t command, bool with_place)
{
    gpio_clear(GPIOA, CS);
    spi_xfer(SPI1, command);
    if (!with_place)
        return;
    spi_xfer(SPI1, FLASH_PLACE >> 16);
    spi_xfer(SPI1, FLASH_PLACE >> 8 & 0xFF);
    spi_xfer(SPI1, FLASH_PLACE & 0xFF);
}

static void flash_end(void) { gpio_set(GPIOA, CS); }

static bool flash_is_ready(void)
{
    for (uint32_t since = system_millis; within(since, LIMIT_MS);) {
        flash_command(0x05, false);
        bool busy = spi_xfer(SPI1, 0xFF) & 1;
        flash_end();
        if (!busy)
            return true;
    }
    return false;
}

static bool try_spi(void)
{
    flash_command(0x9F, false);
    uint32_t identity = 0;
    for (uint32_t at = 0; at < 3; ++at) {
        spi_send(SPI1, 0xFF);
        identity = identity << 8 | spi_read(SPI1);
    }
    flash_end();
    struct line line = EMPTY_LINE;
    line_text(&line, "spi: ");
    line_hex(&line, identity);
    if (identity >> 16 != 0xEF)
        return verdict(line.text, false);
    flash_command(0x06, false);
    flash_end();
    flash_command(0x02, true);
    for (uint32_t at = 0; at < COUNT; ++at)
        spi_xfer(SPI1, (uint8_t)(0x5A ^ at));
    flash_end();
    bool good = flash_is_ready();
    flash_command(0x03, true);
    for (uint32_t at = 0; at < COUNT; ++at)
        good = spi_xfer(SPI1, 0xFF) == (0x5A ^ at) && good;
    spi_send(SPI1, 0xFF);
    spi_clean_disable(SPI1);
    flash_end();
    return verdict(line.text, good);
}

// The LSI has 30 kHz to 60 kHz (DS5319, table 25).
static bool try_rtc(void)
{
    rtc_auto_awake_lsi(399);
    rtc_set_counter_val(0xFFFF);
    rtc_set_alarm_time(0x10000);
    rtc_clear_flag(RTC_CRL_SECF | RTC_CRL_ALRF);
    nvic_enable_irq(RTC_IRQ);
    rtc_interrupt_enable(RTC_CRL_SECF);
    uint32_t since = system_millis;
    while (ticks < TICKS && within(since, 100)) {
    }
    uint32_t took_ms = system_millis - since;
    uint32_t count = rtc_get_counter_val();
    return verdict("rtc:", ticks == TICKS && took_ms >= 13 && took_ms <= 41 && count > 0x10000 && rtc_check_flag(RTC_CRL_ALRF));
}

int main(void)
{
    clock_setup();
    gpio_setup();
    usart_setup();
    adc_setup();
    i2c_setup();
    spi_setup();
    bool good = try_adc();
    good = try_i2c() && good;
    good = try_spi() && good;
    good = try_rtc() && good;
    if (good)
        gpio_clear(GPIOC, LED);
    for (;;)
        WFI();
}
