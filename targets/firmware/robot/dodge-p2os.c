// SPDX-License-Identifier: GPL-2.0-or-later
//
// Finds its way between obstacles with nothing but a serial line to a Pioneer: speeds and turns go out as P2OS commands,
// distances come back in its packets. USART1 (PA9, PA10), 9600 8N1. Lamp 0 is lit while a session is open.

#include "chip/stm32f103.h"
#include "clock.h"
#include "handlers.h"
#include "pin.h"
#include "ring.h"
#include "robot/p2os.h"

#define BAUD 9600u
#define TICK_MS 10u

#define SPEED_MM_S 200
#define TURN_DEG_S 40
#define NEAR_AHEAD_MM 700u // discs 3 to 6, 30 degrees to either side
#define NEAR_HALF_MM 500u  // discs 2 and 7, 50 degrees
#define OLD_MS 1000u       // a reading that says nothing any more
#define LISTEN_MS 2000u    // for the first reading of each disc that is looked at: several rounds of the sonars
#define LOOKED_AT 0x7Eu    // discs 2 to 7
#define FREE_MS 500u

static volatile uint32_t ticks;
static struct ring input, output;
static struct p2os p2os;

void SysTick_Handler(void) { ++ticks; }

void USART1_IRQHandler(void)
{
    uint32_t status = USART1->SR;
    if (status & (USART_SR_RXNE | USART_SR_ORE)) {
        uint8_t byte = (uint8_t)USART1->DR; // takes ORE away as well
        if (status & USART_SR_RXNE)         // otherwise it is the byte that was read before
            ring_put(&input, byte);
    }
    if (status & USART_SR_TXE) {
        uint8_t byte;
        if (ring_get(&output, &byte))
            USART1->DR = byte;
        else
            USART1->CR1 &= ~USART_CR1_TXEIE;
    }
}

static void send(const uint8_t *data, uint32_t count)
{
    for (uint32_t i = 0; i < count; ++i)
        ring_put(&output, data[i]); // a kilobyte is a second of this line: what does not fit is too old anyway
    USART1->CR1 |= USART_CR1_TXEIE;
}

static void start(void)
{
    clock_72mhz();
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_USART1;
    pin_mode(GPIOA, 0, PIN_OUTPUT);
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    pin_pull(GPIOA, 10, true);
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE | USART_CR1_RXNEIE;
    irq_line_enable(USART1_IRQ);
    SYSTICK->LOAD = clock_hclk_hz() / 1000u * TICK_MS - 1;
    SYSTICK->VAL = 0;
    SYSTICK->CTRL = SYSTICK_ENABLE | SYSTICK_TICKINT | SYSTICK_CLKSOURCE;
}

static uint32_t now_ms(void) { return ticks * TICK_MS; }

// Right after a session has begun nothing was heard yet, and neither driving nor turning would have a reason.
static bool listened(void)
{
    return (p2os.sonars_heard & LOOKED_AT) == LOOKED_AT || now_ms() - p2os.opened_ms >= LISTEN_MS;
}

// A disc that was never heard, or not lately, may be standing before a wall for all we know.
static uint32_t range_mm(uint32_t disc)
{
    bool known = p2os.sonars_heard >> disc & 1u && now_ms() - p2os.sonar_ms[disc] < OLD_MS;
    return known ? p2os.sonar_mm[disc] : 0;
}

static uint32_t nearest_mm(uint32_t first, uint32_t last)
{
    uint32_t nearest = P2OS_FAR_MM;
    for (uint32_t disc = first; disc <= last; ++disc)
        if (range_mm(disc) < nearest)
            nearest = range_mm(disc);
    return nearest;
}

static bool blocked(void)
{
    return nearest_mm(2, 5) < NEAR_AHEAD_MM || range_mm(1) < NEAR_HALF_MM || range_mm(6) < NEAR_HALF_MM;
}

static void drive(void)
{
    static int turning; // +1 left, -1 right
    static uint32_t free_ms;
    if (blocked()) {
        free_ms = now_ms();
        if (!turning)
            turning = nearest_mm(0, 3) < nearest_mm(4, 7) ? -1 : 1;
    } else if (turning && now_ms() - free_ms >= FREE_MS) {
        turning = 0;
    }
    p2os_drive(&p2os, turning ? 0 : SPEED_MM_S, (int16_t)(turning * TURN_DEG_S), now_ms());
}

int main(void)
{
    start();
    p2os_start(&p2os, send, now_ms());
    for (;;) {
        uint32_t tick = ticks;
        while (ticks == tick)
            WFI();
        uint8_t byte;
        while (ring_get(&input, &byte))
            p2os_take(&p2os, byte, now_ms());
        p2os_poll(&p2os, now_ms());
        pin_write(GPIOA, 0, p2os.state == P2OS_OPEN);
        if (p2os.state == P2OS_OPEN && listened())
            drive();
    }
}
