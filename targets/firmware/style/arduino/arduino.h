// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of an Arduino core for this chip: what its API promises to a sketch, as functions of C. Pins have numbers, time
// comes from SysTick, everything is made ready before setup(). Only what this image calls.

#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum level { LOW, HIGH };
enum pin_use { INPUT, INPUT_PULLUP, INPUT_ANALOG, OUTPUT, ALTERNATE, ALTERNATE_OPEN_DRAIN };
enum { PA0, PA1, PA4 = 4, PA5, PA6, PA7, PA9 = 9, PB6 = 16 + 6, PB7, PC13 = 32 + 13, LED_BUILTIN = PC13 };

void setup(void);
void loop(void);

// --- wiring

void init(void);
uint32_t millis(void);
uint32_t micros(void);
void delay(uint32_t ms);
void pinMode(uint8_t pin, enum pin_use use);
void digitalWrite(uint8_t pin, enum level level);
uint16_t analogRead(uint8_t pin); // 0 to 4095

// --- Serial: what is printed waits in a ring until the line takes it

void Serial_begin(uint32_t baud);
void Serial_print(const char *text);
void Serial_println(const char *text);

// --- Wire: a message waits in a buffer until endTransmission, and what is read until it is asked for

#define WIRE_BUFFER 32u

enum wire_status { WIRE_SUCCESS, WIRE_TOO_LONG, WIRE_NO_ADDRESS, WIRE_NO_DATA, WIRE_OTHER, WIRE_TIMEOUT };

void Wire_begin(void);
void Wire_setClock(uint32_t hz);
void Wire_beginTransmission(uint8_t address);
size_t Wire_write(uint8_t byte); // bytes that were taken: none when the buffer is full
enum wire_status Wire_endTransmission(bool stop);
uint8_t Wire_requestFrom(uint8_t address, uint8_t count); // how many have come
int Wire_read(void);                                      // -1 when there are no more

// --- SPI

struct spi_settings {
    uint32_t hz;
    uint8_t mode; // CPOL and CPHA
};

void SPI_begin(void);
void SPI_beginTransaction(struct spi_settings settings);
void SPI_endTransaction(void);
uint8_t SPI_transfer(uint8_t byte);
uint16_t SPI_transfer16(uint16_t word);
void SPI_write(const uint8_t *data, uint32_t count); // what comes in meanwhile is lost
