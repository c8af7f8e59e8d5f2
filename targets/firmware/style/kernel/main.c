// SPDX-License-Identifier: GPL-2.0-or-later
//
// Tasks on the kernel: PA0 toggles each millisecond, PA1 each 5 ms, PA2 each 20 ms; they share a counter under a mutex.
// TIM2 interrupts each 4 ms and sends a number through a queue to a reporter, which prints one line for 50 of them over
// USART1 (PA9, 115200 8N1). Below all is the idle task, which sleeps. Built with BUSY=1, the three tasks also work for
// about 70 % of the time: 0.2 of 1 ms, 1 of 5 ms, 6 of 20 ms.

#include "chip/stm32f103.h"
#include "clock.h"
#include "handlers.h"
#include "kernel.h"
#include "pin.h"
#include "text.h"

#define STACK_BYTES 512u
#define BAUD 115200u
#define MESSAGES_PER_LINE 50u

#if BUSY
#define TURNS_PER_MS 12000u // of the loop in work(), six cycles each
#else
#define TURNS_PER_MS 0u
#endif

struct blinker {
    unsigned pin;
    uint32_t period_ticks, work_us;
};

static const struct blinker blinkers[3] = {{0, 1, 200}, {1, 5, 1000}, {2, 20, 6000}};

static struct task blinker_tasks[3], reporter_task, idle_task;
static uint64_t stacks[5][STACK_BYTES / 8];

static struct mutex mutex;
static uint32_t shared; // guarded by the mutex

static uint32_t queue_items[8];
static struct queue queue = {.items = queue_items, .capacity = 8};
static uint32_t lost;

static void work(uint32_t us)
{
    uint32_t value = us;
    for (uint32_t turns = us * TURNS_PER_MS / 1000; turns; --turns) {
        value = value * 1664525u + 1013904223u;
        __asm volatile("" : "+r"(value)); // it is work, even if nobody wants the result
    }
}

static void blink(void *argument)
{
    const struct blinker *blinker = argument;
    for (uint32_t wake = kernel_tick();;) {
        wake += blinker->period_ticks;
        task_sleep_until(wake);
        pin_toggle(GPIOA, blinker->pin);
        work(blinker->work_us);
        mutex_lock(&mutex);
        shared += blinker->period_ticks;
        mutex_unlock(&mutex);
    }
}

static void print(const char *text)
{
    for (; *text; ++text) {
        while (!(USART1->SR & USART_SR_TXE)) {
        }
        USART1->DR = (uint8_t)*text;
    }
}

static void report(void *argument)
{
    (void)argument;
    for (uint32_t expected = 0, wrong = 0;;) {
        for (uint32_t i = 0; i < MESSAGES_PER_LINE; ++i)
            wrong += queue_receive(&queue) != expected++;
        mutex_lock(&mutex);
        uint32_t sum = shared;
        mutex_unlock(&mutex);
        struct line line = EMPTY_LINE;
        line_text(&line, "messages ");
        line_decimal(&line, expected);
        line_text(&line, " wrong ");
        line_decimal(&line, wrong + lost);
        line_text(&line, " sum ");
        line_decimal(&line, sum);
        line_text(&line, "\r\n");
        print(line.text);
    }
}

static void idle(void *argument)
{
    (void)argument;
    for (;;) {
        WFI();
        task_yield(); // nobody of this priority: comes straight back, by way of SVC and PendSV
    }
}

void TIM2_IRQHandler(void)
{
    static uint32_t number;
    TIM2->SR = ~TIM_UIF;
    lost += !queue_send_from_isr(&queue, number++);
}

static void set_up(void)
{
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_USART1;
    RCC->APB1ENR |= RCC_APB1_TIM2;
    for (unsigned i = 0; i < 3; ++i)
        pin_mode(GPIOA, blinkers[i].pin, PIN_OUTPUT);
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE;
    TIM2->PSC = 72 - 1;
    TIM2->ARR = 4000 - 1;
    TIM2->EGR = TIM_EGR_UG;
    TIM2->SR = 0;
    TIM2->DIER = TIM_UIF;
    irq_priority(TIM2_IRQ, KERNEL_LEVEL + 1);
    irq_line_enable(TIM2_IRQ);
    TIM2->CR1 = TIM_CR1_CEN;
}

int main(void)
{
    clock_72mhz();
    set_up();
    for (unsigned i = 0; i < 3; ++i)
        task_create(&blinker_tasks[i], stacks[i], STACK_BYTES, blink, (void *)(uintptr_t)&blinkers[i], 4 - i);
    task_create(&reporter_task, stacks[3], STACK_BYTES, report, 0, 1);
    task_create(&idle_task, stacks[4], STACK_BYTES, idle, 0, 0);
    kernel_start(clock_hclk_hz());
}
