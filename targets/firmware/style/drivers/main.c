// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: a kernel with drivers behind tables of functions. Five threads at once: one writes and reads a 24C02 (I2C1:
// PB6, PB7, 400 kHz), one sends a frame to an SSD1306 on the same bus, one programs a W25Q flash (SPI1, chip select PA4), one
// reads PA0, PA1 and the reference again and again, one waits for an alarm of the RTC. USART1 (PA9), 115200 8N1, says what
// each has found; PC13 is lit when all is well.

#include "board.h"
#include "chip/adc.h"
#include "chip/stm32f103.h"
#include "clock.h"
#include "cycles.h"
#include "device.h"
#include "pin.h"
#include "text.h"

#define BAUD 115200u
#define LED 13
#define EEPROM 0x50
#define DISPLAY 0x3C
#define PAGE 8u
#define PLACE 0x60
#define FLASH_PLACE 0x2000
#define COUNT 32u
#define FRAME 1024u
#define SAMPLINGS 8u
#define REFERENCE_MV 1200u

// --- the memories' threads

static int i2c(struct i2c_message *messages, uint32_t count, uint8_t address)
{
    const struct device *bus = device_get("i2c1");
    return ((const struct i2c_api *)bus->api)->transfer(bus, messages, count, address);
}

static int i2c_write(uint8_t address, uint8_t *data, uint32_t count)
{
    return i2c(&(struct i2c_message){data, count, I2C_STOP}, 1, address);
}

static int i2c_write_read(uint8_t address, uint8_t place, uint8_t *data, uint32_t count)
{
    struct i2c_message both[] = {{&place, 1, 0}, {data, count, I2C_READ | I2C_STOP}};
    return i2c(both, 2, address);
}

static bool eeprom_answers(void)
{
    uint8_t place = 0;
    for (uint32_t tries = 0; tries < 10; ++tries) {
        if (!i2c_write(EEPROM, &place, 1))
            return true;
        sleep_ms(1);
    }
    return false;
}

static bool try_eeprom(void)
{
    uint8_t in[2 * PAGE];
    for (uint8_t half = 0; half < 2; ++half) {
        uint8_t out[1 + PAGE] = {(uint8_t)(PLACE + PAGE * half)};
        for (uint32_t at = 0; at < PAGE; ++at)
            out[1 + at] = (uint8_t)(0x80 + 5 * (PAGE * half + at));
        if (!eeprom_answers() || i2c_write(EEPROM, out, sizeof out) || !eeprom_answers())
            return false;
    }
    for (uint32_t count = 1; count <= sizeof in; ++count) { // the last one by DMA
        if (i2c_write_read(EEPROM, PLACE, in, count))
            return false;
        for (uint32_t at = 0; at < count; ++at)
            if (in[at] != (uint8_t)(0x80 + 5 * at))
                return false;
    }
    return true;
}

static bool try_display(void)
{
    static uint8_t on[] = {0x00, 0xAE, 0xA8, 63, 0xD3, 0, 0x40, 0x8D, 0x14, 0x20, 0, 0xA1, 0xC8, 0xDA, 0x12, 0xA4, 0xA6, 0xAF};
    static uint8_t frame[1 + FRAME] = {0x40};
    for (uint32_t at = 0; at < FRAME; ++at)
        frame[1 + at] = (uint8_t)(at ^ at >> 7);
    return !i2c_write(DISPLAY, on, sizeof on) && !i2c_write(DISPLAY, frame, sizeof frame);
}

static struct sem flash_done = {.limit = 1};
static int flash_result;

static void flash_called_back(const struct device *device, int result, void *argument)
{
    (void)device;
    flash_result = result;
    sem_give(argument);
}

static bool flash(const uint8_t *command, uint32_t command_count, const uint8_t *out, uint8_t *in, uint32_t count)
{
    const struct device *bus = device_get("spi1");
    const struct spi_api *api = bus->api;
    struct spi_transfer parts[] = {{command, 0, command_count, count != 0}, {out, in, count, false}};
    for (uint32_t at = 0; at < 2 && parts[at].count; ++at) {
        api->transceive(bus, &parts[at], flash_called_back, &flash_done);
        if (sem_take(&flash_done, 50) || flash_result)
            return false;
    }
    return true;
}

static bool try_flash(void)
{
    static const uint8_t identify[] = {0x9F}, enable[] = {0x06}, state[] = {0x05};
    static const uint8_t program[] = {0x02, 0, FLASH_PLACE >> 8, 0}, read[] = {0x03, 0, FLASH_PLACE >> 8, 0};
    uint8_t out[COUNT], in[COUNT];
    if (!flash(identify, 1, 0, in, 3) || in[0] != 0xEF)
        return false;
    for (uint32_t at = 0; at < COUNT; ++at)
        out[at] = (uint8_t)(at * 11);
    if (!flash(enable, 1, 0, 0, 0) || !flash(program, 4, out, 0, COUNT))
        return false;
    do {
        sleep_ms(1);
        if (!flash(state, 1, 0, in, 1))
            return false;
    } while (in[0] & 1);
    if (!flash(read, 4, 0, in, COUNT))
        return false;
    for (uint32_t at = 0; at < COUNT; ++at)
        if (in[at] != out[at])
            return false;
    return true;
}

// --- the other threads

static uint32_t means_mv[2];

static bool try_adc(void)
{
    static uint16_t samples[SAMPLINGS][3];
    const struct device *adc = device_get("adc1");
    struct adc_sequence sequence = {1u << 0 | 1u << 1 | 1u << ADC_VREFINT, samples[0], SAMPLINGS, true};
    for (uint32_t round = 0; round < 5; ++round) {
        if (((const struct adc_api *)adc->api)->read(adc, &sequence))
            return false;
        uint32_t sums[3] = {0};
        for (uint32_t at = 0; at < SAMPLINGS; ++at)
            for (uint32_t channel = 0; channel < 3; ++channel)
                sums[channel] += samples[at][channel];
        if (!sums[2])
            return false;
        means_mv[0] = sums[0] * REFERENCE_MV / sums[2];
        means_mv[1] = sums[1] * REFERENCE_MV / sums[2];
        sequence.calibrate = false;
        sleep_ms(3);
    }
    return true;
}

static struct sem alarm = {.limit = 1};
static uint32_t alarm_value;

static void alarm_came(const struct device *device, uint32_t value, void *argument)
{
    (void)device;
    alarm_value = value;
    sem_give(argument);
}

// Between the second tick and the third there are 10 ms.
static bool try_alarm(void)
{
    const struct device *rtc = device_get("rtc");
    const struct counter_api *api = rtc->api;
    uint64_t since_ms = 0;
    for (uint32_t round = 0; round < 2; ++round) {
        since_ms = uptime_ms();
        api->set_alarm(rtc, 1, alarm_came, &alarm);
        if (sem_take(&alarm, 30))
            return false;
    }
    uint64_t took_ms = uptime_ms() - since_ms;
    return took_ms >= 9 && took_ms <= 11 && api->value(rtc) >= 2 && alarm_value <= api->value(rtc);
}

// --- who says what they have found

static struct trial {
    const char *name;
    bool (*body)(void);
    bool good;
    struct thread thread;
    uint64_t stack[64];
} trials[] = {
    {.name = "eeprom", .body = try_eeprom}, {.name = "display", .body = try_display}, {.name = "flash", .body = try_flash},
    {.name = "adc", .body = try_adc},       {.name = "alarm", .body = try_alarm},
};

#define TRIALS (sizeof trials / sizeof *trials)

static struct sem over = {.limit = TRIALS};

#define TRIAL_THREAD(number)                                                                                            \
    static void thread_##number(void)                                                                                   \
    {                                                                                                                   \
        trials[number].good = trials[number].body();                                                                    \
        sem_give(&over);                                                                                                \
    }

TRIAL_THREAD(0)
TRIAL_THREAD(1)
TRIAL_THREAD(2)
TRIAL_THREAD(3)
TRIAL_THREAD(4)

static void (*const bodies[])(void) = {thread_0, thread_1, thread_2, thread_3, thread_4};

static void say(const char *text)
{
    for (; *text; ++text) {
        while (!(USART1->SR & USART_SR_TXE)) {
        }
        USART1->DR = (uint8_t)*text;
    }
}

static void led(bool lit)
{
    const struct device *port = device_get("gpioc");
    ((const struct gpio_api *)port->api)->set(port, LED, !lit);
}

static void main_body(void)
{
    bool good = true;
    led(false);
    for (uint32_t at = 0; at < TRIALS; ++at)
        thread_create(&trials[at].thread, trials[at].stack, sizeof trials[at].stack, bodies[at], 5 + at);
    for (uint32_t at = 0; at < TRIALS; ++at)
        sem_take(&over, FOREVER);
    for (uint32_t at = 0; at < TRIALS; ++at) {
        say(trials[at].name);
        say(trials[at].good ? ": ok\r\n" : ": wrong\r\n");
        good = good && trials[at].good;
    }
    struct line line = EMPTY_LINE;
    line_decimal(&line, means_mv[0]);
    line_text(&line, " mV, ");
    line_decimal(&line, means_mv[1]);
    line_text(&line, " mV\r\n");
    say(line.text);
    led(good);
    for (;;)
        sleep_ms(1000);
}

int main(void)
{
    clock_72mhz();
    cycles_start();
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_USART1;
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE;
    devices_init();
    kernel_start(main_body);
}
