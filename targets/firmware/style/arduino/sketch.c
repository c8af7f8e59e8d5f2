// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: a sketch. setup() writes and reads a 24C02 by Wire and a W25Q flash by SPI (chip select PA4), and looks for
// an MPU-6050; loop() says each 10 ms what is at PA0 and PA1, and how the sensor lies. Serial (PA9) has 115200 8N1; PC13 is
// lit when both memories are well.

#include "arduino.h"
#include "text.h"

#define EEPROM 0x50
#define IMU 0x68
#define PLACE 0x40
#define PAGE 8u
#define FLASH_PLACE 0x1000u
#define COUNT 40u
#define G 16384 // at a full scale of 2 g

static const struct spi_settings fast = {18000000, 0}, slow = {4000000, 3};
static bool has_imu;
static uint32_t next_ms;

static void say(const char *what, bool good)
{
    Serial_print(what);
    Serial_println(good ? ": ok" : ": wrong");
}

// --- EEPROM

static bool answers(uint8_t address, uint32_t limit_ms)
{
    for (uint32_t begin = millis(); millis() - begin < limit_ms;) {
        Wire_beginTransmission(address);
        if (Wire_endTransmission(true) == WIRE_SUCCESS)
            return true;
        delay(1);
    }
    return false;
}

static bool buffer_has_an_end(void)
{
    Wire_beginTransmission(EEPROM);
    for (uint32_t at = 0; at < WIRE_BUFFER; ++at)
        if (!Wire_write(0))
            return false;
    return !Wire_write(0) && Wire_endTransmission(true) == WIRE_TOO_LONG;
}

static bool try_eeprom(void)
{
    Wire_beginTransmission(EEPROM);
    Wire_write(PLACE);
    for (uint32_t at = 0; at < PAGE; ++at)
        Wire_write((uint8_t)(0x31 + at * at));
    if (Wire_endTransmission(true) != WIRE_SUCCESS || !answers(EEPROM, 10))
        return false;
    for (uint8_t count = 1; count <= PAGE; ++count) {
        Wire_beginTransmission(EEPROM);
        Wire_write(PLACE);
        if (Wire_endTransmission(count % 2) != WIRE_SUCCESS || Wire_requestFrom(EEPROM, count) != count)
            return false;
        for (uint32_t at = 0; at < count; ++at)
            if (Wire_read() != (uint8_t)(0x31 + at * at))
                return false;
        if (Wire_read() != -1)
            return false;
    }
    return true;
}

// --- flash

static void command(uint8_t code, struct spi_settings settings)
{
    SPI_beginTransaction(settings);
    digitalWrite(PA4, LOW);
    SPI_transfer(code);
}

static void command_end(void)
{
    SPI_endTransaction();
    digitalWrite(PA4, HIGH);
}

static void place(void)
{
    SPI_transfer(FLASH_PLACE >> 16);
    SPI_transfer16(FLASH_PLACE & 0xFFFF);
}

static bool flash_is_ready(void)
{
    bool busy = true;
    for (uint32_t begin = millis(); busy && millis() - begin < 10;) {
        command(0x05, fast);
        busy = SPI_transfer(0xFF) & 1;
        command_end();
    }
    return !busy;
}

static bool try_flash(void)
{
    command(0x9F, slow);
    bool is_there = SPI_transfer(0xFF) == 0xEF;
    SPI_transfer16(0xFFFF);
    command_end();
    if (!is_there)
        return false;
    uint8_t data[COUNT];
    for (uint32_t at = 0; at < COUNT; ++at)
        data[at] = (uint8_t)(3 * at + 1);
    command(0x06, fast);
    command_end();
    command(0x02, fast);
    place();
    SPI_write(data, COUNT);
    command_end();
    bool good = flash_is_ready();
    command(0x03, slow);
    place();
    for (uint32_t at = 0; at < COUNT; ++at)
        good = SPI_transfer(0xFF) == data[at] && good;
    command_end();
    return good;
}

// --- inertial sensor

static uint8_t imu_read(uint8_t place, uint8_t count)
{
    Wire_beginTransmission(IMU);
    Wire_write(place);
    return Wire_endTransmission(false) == WIRE_SUCCESS ? Wire_requestFrom(IMU, count) : 0;
}

static bool start_imu(void)
{
    if (!answers(IMU, 25) || !imu_read(0x75, 1) || Wire_read() != 0x68)
        return false;
    Wire_beginTransmission(IMU);
    Wire_write(0x6B); // PWR_MGMT_1
    Wire_write(1);
    return Wire_endTransmission(true) == WIRE_SUCCESS;
}

static const char *lies(void)
{
    if (imu_read(0x3B, 14) != 14)
        return "gone";
    int16_t axes[3];
    for (uint32_t axis = 0; axis < 3; ++axis) {
        int high = Wire_read();
        axes[axis] = (int16_t)(high << 8 | Wire_read());
    }
    return axes[2] > G / 2 ? "flat" : axes[2] < -G / 2 ? "upside down" : "on its side";
}

// --- the sketch

void setup(void)
{
    Serial_begin(115200);
    digitalWrite(LED_BUILTIN, HIGH);
    pinMode(LED_BUILTIN, OUTPUT);
    digitalWrite(PA4, HIGH);
    pinMode(PA4, OUTPUT);
    pinMode(PA0, INPUT_ANALOG);
    pinMode(PA1, INPUT_ANALOG);
    Wire_begin();
    SPI_begin();
    Serial_println("style-arduino");
    bool buffer = buffer_has_an_end(), eeprom = try_eeprom(), flash = try_flash();
    say("buffer", buffer);
    say("eeprom", eeprom);
    say("flash", flash);
    Wire_setClock(400000);
    has_imu = start_imu();
    say("imu", has_imu);
    digitalWrite(LED_BUILTIN, eeprom && flash && buffer ? LOW : HIGH);
    next_ms = millis();
}

void loop(void)
{
    next_ms += 10;
    while (millis() < next_ms)
        delay(1);
    struct line line = EMPTY_LINE;
    line_decimal(&line, analogRead(PA0) * 3300u / 4095u);
    line_text(&line, " mV ");
    line_decimal(&line, analogRead(PA1) * 3300u / 4095u);
    line_text(&line, " mV");
    if (has_imu) {
        line_text(&line, ", ");
        line_text(&line, lies());
    }
    Serial_println(line.text);
}
