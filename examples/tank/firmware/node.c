// SPDX-License-Identifier: GPL-2.0-or-later
//
// A node of the tank bus on a Blue Pill (STM32F103): USART1 at PA9 and PA10, 115200 baud from the 8 MHz HSI. The level is
// a constant, and the valve is the LED at PC13, which is lit while it is open.

#include <stdbool.h>
#include <stdint.h>

#define REG(address) (*(volatile uint32_t *)(address))
#define RCC_APB2ENR REG(0x40021018) // RM0008 7.3.7: IOPAEN 2, IOPCEN 4, USART1EN 14
#define GPIOA_CRH REG(0x40010804)   // RM0008 9.2.2
#define GPIOC_CRH REG(0x40011004)
#define GPIOC_BSRR REG(0x40011010)
#define USART1_SR REG(0x40013800) // RM0008 27.6: RXNE 5, TXE 7
#define USART1_DR REG(0x40013804)
#define USART1_BRR REG(0x40013808)
#define USART1_CR1 REG(0x4001380C) // UE 13, TE 3, RE 2
#define SYST_CSR REG(0xE000E010)   // DDI0403 B3.3: ENABLE 0, TICKINT 1, CLKSOURCE 2
#define SYST_RVR REG(0xE000E014)

#define HSI_HZ 8000000u
#define BAUD 115200u
#define LEVEL_MM 1200u
#define LONGEST 8u
#define GAP_MS 20u
#define WATCHDOG_MS 1000u

enum { READ = 0x01, SET_VALVE = 0x02, LEVEL = 0x81, REFUSED = 0xFF };

static volatile uint32_t now_ms;
static uint8_t held[LONGEST + 3];
static uint32_t count, latest_ms, fed_ms;
static uint8_t percent;
static bool tripped;

// CRC-16/IBM-3740: polynomial 0x1021, begins at 0xFFFF.
static uint16_t crc16(const uint8_t *data, uint32_t size)
{
    uint16_t crc = 0xFFFF;
    while (size--) {
        crc ^= (uint16_t)(*data++ << 8);
        for (int bit = 0; bit < 8; ++bit)
            crc = (uint16_t)(crc & 0x8000 ? crc << 1 ^ 0x1021 : crc << 1);
    }
    return crc;
}

static void put(uint8_t byte)
{
    while (!(USART1_SR & 1u << 7))
        ;
    USART1_DR = byte;
}

static void send(const uint8_t *payload, uint8_t size)
{
    uint8_t body[LONGEST + 1] = {size};
    for (uint32_t at = 0; at < size; ++at)
        body[at + 1] = payload[at];
    uint16_t crc = crc16(body, size + 1u);
    for (uint32_t at = 0; at <= size; ++at)
        put(body[at]);
    put((uint8_t)crc);
    put((uint8_t)(crc >> 8));
}

static void set_valve(uint8_t to)
{
    percent = to;
    GPIOC_BSRR = to ? 1u << 29 : 1u << 13; // the LED is lit when PC13 is low
}

static void take(const uint8_t *payload, uint32_t size)
{
    bool opens = size == 2 && payload[0] == SET_VALVE && payload[1] <= 100;
    if (!opens && !(size == 1 && payload[0] == READ)) {
        uint8_t refused[] = {REFUSED, payload[0]};
        send(refused, sizeof refused);
        return;
    }
    if (opens) {
        set_valve(payload[1]);
        tripped = false;
    }
    fed_ms = now_ms;
    uint8_t level[] = {LEVEL, (uint8_t)LEVEL_MM, LEVEL_MM >> 8, percent, tripped};
    send(level, sizeof level);
}

static void drop(uint32_t size)
{
    count -= size;
    for (uint32_t at = 0; at < count; ++at)
        held[at] = held[at + size];
}

static void look(void)
{
    while (count) {
        uint32_t size = held[0];
        if (size < 1 || size > LONGEST) {
            drop(1);
            continue;
        }
        if (count < size + 3)
            return;
        uint16_t crc = crc16(held, size + 1);
        if (held[size + 1] != (uint8_t)crc || held[size + 2] != crc >> 8) {
            drop(1);
            continue;
        }
        take(held + 1, size);
        drop(size + 3);
    }
}

void tick(void);
void tick(void)
{
    ++now_ms;
}

int main(void);
int main(void)
{
    RCC_APB2ENR |= 1u << 2 | 1u << 4 | 1u << 14;
    GPIOA_CRH = (GPIOA_CRH & ~0xFF0u) | 0x4B0u;       // PA9 alternate push-pull, PA10 floating input
    GPIOC_CRH = (GPIOC_CRH & ~0xF00000u) | 0x200000u; // PC13 output, 2 MHz
    set_valve(0);
    USART1_BRR = (HSI_HZ + BAUD / 2) / BAUD;
    USART1_CR1 = 1u << 13 | 1u << 3 | 1u << 2;
    SYST_RVR = HSI_HZ / 1000 - 1;
    SYST_CSR = 7;
    for (;;) {
        if (USART1_SR & 1u << 5) {
            if (now_ms - latest_ms > GAP_MS)
                count = 0;
            latest_ms = now_ms;
            held[count++] = (uint8_t)USART1_DR;
            look();
        }
        if (percent && now_ms - fed_ms >= WATCHDOG_MS) {
            set_valve(0);
            tripped = true;
        }
    }
}

// --- start-up: sections.ld says where data and bss are

extern uint32_t data_load[], data_start[], data_end[], bss_start[], bss_end[], stack_top[];

void reset(void);
void reset(void)
{
    for (uint32_t *from = data_load, *to = data_start; to < data_end;)
        *to++ = *from++;
    for (uint32_t *to = bss_start; to < bss_end;)
        *to++ = 0;
    main();
}

static void stop(void)
{
    for (;;)
        ;
}

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    stack_top, reset, stop, stop, stop, stop, stop, 0, 0, 0, 0, stop, stop, 0, stop, tick,
};
