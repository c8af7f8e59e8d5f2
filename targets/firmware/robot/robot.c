// SPDX-License-Identifier: GPL-2.0-or-later

#include "robot/robot.h"

#include "chip/stm32f103.h"
#include "clock.h"
#include "handlers.h"
#include "pin.h"
#include "ring.h"

#define TICK_MS 10u
#define BAUD 115200u

#ifndef REVERSED
#define REVERSED 0 // 1: a mistake, the wires of the left motor the other way round
#endif

struct wire {
    port_t port;
    uint8_t pin;
};

static const struct wire DISTANCE[8] = {
    {GPIOA, 4}, {GPIOA, 5}, {GPIOA, 6}, {GPIOA, 7}, {GPIOB, 0}, {GPIOB, 1}, {GPIOB, 10}, {GPIOB, 11},
};
static const struct wire ENCODER[2][3] = {
    {{GPIOB, 4}, {GPIOB, 3}, {GPIOA, 15}},
    {{GPIOC, 13}, {GPIOC, 14}, {GPIOC, 15}},
};
static const struct wire LAMP[3] = {{GPIOA, 0}, {GPIOA, 11}, {GPIOA, 12}};

static volatile uint32_t ticks;
static struct ring output;

void SysTick_Handler(void) { ++ticks; }

void USART1_IRQHandler(void)
{
    uint8_t byte;
    if (ring_get(&output, &byte))
        USART1->DR = byte;
    else
        USART1->CR1 &= ~USART_CR1_TXEIE;
}

static void start_pins(void)
{
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOA | RCC_APB2_GPIOB | RCC_APB2_GPIOC | RCC_APB2_USART1;
    AFIO->MAPR = AFIO_MAPR_SWD_ONLY; // PB3, PB4 and PA15 belong to JTAG after reset
    for (unsigned i = 0; i < 8; ++i)
        pin_pull(DISTANCE[i].port, DISTANCE[i].pin, false);
    for (unsigned i = 0; i < 3; ++i) {
        pin_pull(ENCODER[LEFT][i].port, ENCODER[LEFT][i].pin, false);
        pin_pull(ENCODER[RIGHT][i].port, ENCODER[RIGHT][i].pin, false);
        pin_mode(LAMP[i].port, LAMP[i].pin, PIN_OUTPUT);
    }
    robot_drive(0, 0);
    robot_connect(false);
    pin_write(GPIOB, 13, false);
    for (unsigned pin = 1; pin <= 3; ++pin)
        pin_mode(GPIOA, pin, PIN_OUTPUT);
    for (unsigned pin = 5; pin <= 7; ++pin)
        pin_mode(GPIOB, pin, PIN_OUTPUT);
    pin_mode(GPIOB, 12, PIN_OUTPUT);
    pin_mode(GPIOB, 13, PIN_OUTPUT);
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
}

void robot_start(void)
{
    clock_72mhz();
    start_pins();
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE;
    irq_line_enable(USART1_IRQ);
    SYSTICK->LOAD = clock_hclk_hz() / 1000u * TICK_MS - 1;
    SYSTICK->VAL = 0;
    SYSTICK->CTRL = SYSTICK_ENABLE | SYSTICK_TICKINT | SYSTICK_CLKSOURCE;
}

void robot_motor(enum side side, int code)
{
    uint32_t word = (uint32_t)code & 7u;
    if (side == LEFT) { // comm1 is PB7, comm3 is PB5
        uint32_t bits = REVERSED ? word << 5 : (word & 1u) << 7 | (word & 2u) << 5 | (word & 4u) << 3;
        GPIOB->BSRR = bits | 0xE0u << 16;
    } else { // comm1 is PA1, comm3 is PA3
        GPIOA->BSRR = word << 1 | 0x0Eu << 16;
    }
}

void robot_drive(int left, int right)
{
    robot_motor(LEFT, left);
    robot_motor(RIGHT, right);
}

uint8_t robot_obstacles(void)
{
    uint8_t obstacles = 0;
    for (unsigned i = 0; i < 8; ++i)
        obstacles |= (uint8_t)(pin_read(DISTANCE[i].port, DISTANCE[i].pin) << i);
    return obstacles;
}

unsigned robot_encoder(enum side side)
{
    unsigned number = 0;
    for (unsigned i = 0; i < 3; ++i)
        number |= (unsigned)pin_read(ENCODER[side][i].port, ENCODER[side][i].pin) << i;
    return number;
}

void robot_connect(bool wanted) { pin_write(GPIOB, 12, wanted); }

void robot_lamp(unsigned number, bool on) { pin_write(LAMP[number].port, LAMP[number].pin, on); }

uint32_t robot_now_ms(void) { return ticks * TICK_MS; }

void robot_wait_tick(void)
{
    uint32_t tick = ticks;
    while (ticks == tick)
        WFI();
}

void robot_wait_ms(uint32_t span_ms)
{
    uint32_t end_ms = robot_now_ms() + span_ms;
    while ((int32_t)(robot_now_ms() - end_ms) < 0)
        robot_wait_tick();
}

void robot_say(const char *text)
{
    for (; *text; ++text)
        while (!ring_put(&output, (uint8_t)*text)) {
            USART1->CR1 |= USART_CR1_TXEIE; // a text longer than the ring: its beginning has to go first
            robot_wait_tick();
        }
    USART1->CR1 |= USART_CR1_TXEIE;
}
