// SPDX-License-Identifier: GPL-2.0-or-later
//
// Both servos of the head on one Blue Pill (STM32F103): the bus is USART1 at PA9 and PA10, 115200 baud from the 8 MHz HSI.
// There is no motor: an axis turns in memory, without load, as fast as a servo does, and TIM2 puts where it is on PA0 (pan)
// and PA1 (tilt) as the pulses of a hobby servo, 1500 us in the middle and 10 us for a degree.

#include <stdbool.h>
#include <stdint.h>

#define REG(address) (*(volatile uint32_t *)(address))
#define RCC_APB2ENR REG(0x40021018) // RM0008 7.3.7: IOPAEN 2, USART1EN 14
#define RCC_APB1ENR REG(0x4002101C) // TIM2EN 0
#define GPIOA_CRL REG(0x40010800)   // RM0008 9.2.1
#define GPIOA_CRH REG(0x40010804)
#define USART1_SR REG(0x40013800) // RM0008 27.6: RXNE 5, TXE 7
#define USART1_DR REG(0x40013804)
#define USART1_BRR REG(0x40013808)
#define USART1_CR1 REG(0x4001380C) // UE 13, RXNEIE 5, TE 3, RE 2
#define TIM2_CR1 REG(0x40000000)   // RM0008 15.4: CEN 0
#define TIM2_CCMR1 REG(0x40000018) // OC1M 6:4, OC1PE 3, OC2M 14:12, OC2PE 11; 6 is PWM mode 1
#define TIM2_CCER REG(0x40000020)  // CC1E 0, CC2E 4
#define TIM2_PSC REG(0x40000028)
#define TIM2_ARR REG(0x4000002C)
#define TIM2_CCR ((volatile uint32_t *)0x40000034)
#define SYST_CSR REG(0xE000E010) // DDI0403 B3.3: ENABLE 0, TICKINT 1, CLKSOURCE 2
#define SYST_RVR REG(0xE000E014)
#define NVIC_ISER1 REG(0xE000E104) // interrupt 37 is USART1: RM0008 table 63

#define HSI_HZ 8000000u
#define BAUD 115200u
#define SYNC 0xA5u
#define LONGEST 8u
#define GAP_MS 20u
#define WATCHDOG_MS 1000u
#define PARTS 100       // of 0.01 degrees: what an angle is counted in
#define STEP (6 * PARTS) // in 1 ms at 60 degrees/s

enum { GOAL = 0x01, READ = 0x02, TORQUE = 0x03, STATUS = 0x81, REFUSED = 0xFF };
enum { DONE, SENSELESS, OUT_OF_RANGE, TORQUE_OFF };

struct servo {
    int32_t at, goal; // PARTS of 0.01 degrees
    int16_t limit_cdeg;
    uint32_t fed_ms;
    bool torque, tripped;
};

static volatile uint32_t now_ms, filled, latest_ms;
static volatile uint8_t heard[64];
static struct servo servos[2];
static uint8_t held[LONGEST + 4];
static uint32_t count, emptied;

static uint8_t checksum(const uint8_t *data, uint32_t size)
{
    uint8_t sum = 0;
    while (size--)
        sum = (uint8_t)(sum + *data++);
    return (uint8_t)~sum;
}

static void put(uint8_t byte)
{
    while (!(USART1_SR & 1u << 7))
        ;
    USART1_DR = byte;
}

static void send(uint8_t id, const uint8_t *payload, uint8_t size)
{
    uint8_t body[LONGEST + 2] = {id, size};
    for (uint32_t at = 0; at < size; ++at)
        body[at + 2] = payload[at];
    put(SYNC);
    for (uint32_t at = 0; at < size + 2u; ++at)
        put(body[at]);
    put(checksum(body, size + 2u));
}

static int obey(struct servo *servo, const uint8_t *payload, uint32_t size)
{
    if (payload[0] == READ && size == 1)
        return DONE;
    if (payload[0] == TORQUE && size == 2) {
        servo->goal = servo->at;
        servo->torque = payload[1] != 0;
        servo->tripped = false;
        return DONE;
    }
    if (payload[0] != GOAL || size != 3)
        return SENSELESS;
    int16_t angle_cdeg = (int16_t)(payload[1] | payload[2] << 8);
    if (angle_cdeg > servo->limit_cdeg || angle_cdeg < -servo->limit_cdeg)
        return OUT_OF_RANGE;
    if (!servo->torque)
        return TORQUE_OFF;
    servo->goal = angle_cdeg * PARTS;
    return DONE;
}

static void take(uint8_t id, const uint8_t *payload, uint32_t size)
{
    if (id < 1 || id > 2)
        return;
    struct servo *servo = &servos[id - 1];
    int why = obey(servo, payload, size);
    servo->fed_ms = now_ms;
    if (why) {
        uint8_t refused[] = {REFUSED, (uint8_t)why};
        send(id, refused, sizeof refused);
        return;
    }
    int32_t angle_cdeg = servo->at / PARTS;
    uint8_t status[] = {STATUS, (uint8_t)angle_cdeg, (uint8_t)(angle_cdeg >> 8), 0, servo->torque, servo->tripped};
    send(id, status, sizeof status);
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
        if (held[0] != SYNC || (count > 2 && (held[2] < 1 || held[2] > LONGEST))) {
            drop(1);
            continue;
        }
        if (count < 4 || count < held[2] + 4u)
            return;
        uint32_t size = held[2];
        if (held[size + 3] != checksum(held + 1, size + 2)) {
            drop(1);
            continue;
        }
        take(held[1], held + 3, size);
        drop(size + 4);
    }
}

static void move(struct servo *servo)
{
    if (servo->torque && now_ms - servo->fed_ms >= WATCHDOG_MS) {
        servo->torque = false;
        servo->tripped = true;
    }
    if (!servo->torque)
        return;
    int32_t missing = servo->goal - servo->at;
    servo->at += missing > STEP ? STEP : missing < -STEP ? -STEP : missing;
}

void tick(void);
void tick(void)
{
    ++now_ms;
}

void listen(void);
void listen(void)
{
    if (USART1_SR & 1u << 5) {
        heard[filled++ % sizeof heard] = (uint8_t)USART1_DR;
        latest_ms = now_ms;
    }
}

// Sleep, unless something has come meanwhile; an interrupt that is pending ends it at once.
static void rest(void)
{
    __asm volatile("cpsid i" ::: "memory");
    if (emptied == filled)
        __asm volatile("wfi");
    __asm volatile("cpsie i" ::: "memory");
}

int main(void);
int main(void)
{
    RCC_APB2ENR |= 1u << 2 | 1u << 14;
    RCC_APB1ENR |= 1u << 0;
    GPIOA_CRL = (GPIOA_CRL & ~0xFFu) | 0xAAu;   // PA0 and PA1 alternate push-pull, 2 MHz
    GPIOA_CRH = (GPIOA_CRH & ~0xFF0u) | 0x4B0u; // PA9 alternate push-pull, PA10 floating input
    USART1_BRR = (HSI_HZ + BAUD / 2) / BAUD;
    USART1_CR1 = 1u << 13 | 1u << 5 | 1u << 3 | 1u << 2;
    NVIC_ISER1 = 1u << (37 - 32);
    servos[0].limit_cdeg = 9000;
    servos[1].limit_cdeg = 6000;
    TIM2_PSC = HSI_HZ / 1000000 - 1;
    TIM2_ARR = 20000 - 1;
    TIM2_CCMR1 = 6u << 4 | 1u << 3 | 6u << 12 | 1u << 11;
    TIM2_CCER = 1u << 0 | 1u << 4;
    TIM2_CR1 = 1;
    SYST_RVR = HSI_HZ / 1000 - 1;
    SYST_CSR = 7;
    uint32_t moved_ms = 0;
    for (;;) {
        rest();
        if (emptied != filled) {
            held[count++] = heard[emptied++ % sizeof heard];
            look();
        } else if (now_ms - latest_ms > GAP_MS) {
            count = 0;
        }
        while (moved_ms != now_ms) {
            ++moved_ms;
            for (uint32_t at = 0; at < 2; ++at) {
                move(&servos[at]);
                TIM2_CCR[at] = (uint32_t)(1500 + servos[at].at / PARTS / 10);
            }
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

__attribute__((section(".vectors"), used)) static const void *const vectors[16 + 38] = {
    stack_top, reset, stop, stop, stop, stop, stop, 0, 0, 0, 0, stop, stop, 0, stop, tick, [16 + 37] = listen,
};
