// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: a kernel whose critical sections are PRIMASK, and which switches tasks within them by SVC. A masked SVC
// escalates to HardFault; its handler takes it for a system call if the half-word before the stacked PC is one (DDI 0403,
// B1.5.4 and B1.5.6), and for a crash otherwise. PA0 toggles each millisecond, PA1 each 5 ms; USART1 (PA9, 115200 8N1)
// prints a line for 20 toggles of PA1. A crash lights the LED (PC13) and stops.

#include "chip/stm32f103.h"
#include "clock.h"
#include "handlers.h"
#include "pin.h"
#include "startup.h"
#include "text.h"

#define BAUD 115200u
#define LED 13
#define STACK_WORDS 128u
#define CALL_SWITCH 0xDF00u // svc #0

struct task {
    uint32_t *sp; // first: the switch knows
    uint32_t wake_tick;
};

static struct task fast, slow, idle;
static struct task *const tasks[] = {&fast, &slow}; // the more urgent first
static uint64_t stacks[3][STACK_WORDS / 2];

struct task *kernel_current = &idle; // also known to the switch

static volatile uint32_t tick;
static uint32_t switches;

// --- The switch

struct task *kernel_choose(void);
void kernel_crash(void);

struct task *kernel_choose(void)
{
    SCB->HFSR = HFSR_FORCED; // write one to clear
    ++switches;
    for (uint32_t i = 0; i < sizeof tasks / sizeof *tasks; ++i)
        if ((int32_t)(tick - tasks[i]->wake_tick) >= 0)
            return tasks[i];
    return &idle;
}

void kernel_crash(void)
{
    pin_write(GPIOC, LED, false);
    for (;;) {
    }
}

__attribute__((naked)) void HardFault_Handler(void)
{
    __asm volatile("tst lr, #4\n"
                   "beq kernel_crash\n" // not from a task
                   "mrs r0, psp\n"
                   "ldr r1, [r0, #24]\n"
                   "ldrh r1, [r1, #-2]\n"
                   "cmp r1, %0\n"
                   "bne kernel_crash\n"
                   "stmdb r0!, {r4-r11}\n"
                   "ldr r4, =kernel_current\n"
                   "ldr r1, [r4]\n"
                   "str r0, [r1]\n"
                   "mov r5, lr\n"
                   "bl kernel_choose\n"
                   "mov lr, r5\n"
                   "str r0, [r4]\n"
                   "ldr r1, [r0]\n"
                   "ldmia r1!, {r4-r11}\n"
                   "msr psp, r1\n"
                   "bx lr\n" // PRIMASK is still set: whoever goes on now was switched away masked too
                   ".ltorg" ::"i"(CALL_SWITCH));
}

static void switch_task(void) { __asm volatile("svc #0" ::: "memory"); }

// --- Tasks

static void sleep_until(uint32_t wake_tick)
{
    irq_disable();
    kernel_current->wake_tick = wake_tick;
    switch_task();
    irq_enable();
}

static void blink_fast(void)
{
    irq_enable();
    for (uint32_t wake = 0;;) {
        sleep_until(++wake);
        pin_toggle(GPIOA, 0);
    }
}

static void print(const char *text)
{
    for (; *text; ++text) {
        while (!(USART1->SR & USART_SR_TXE))
            sleep_until(tick); // whoever is more urgent goes first
        USART1->DR = (uint8_t)*text;
    }
}

static void blink_slow(void)
{
    irq_enable();
    for (uint32_t wake = 0, toggles = 0;;) {
        sleep_until(wake += 5);
        pin_toggle(GPIOA, 1);
        if (++toggles % 20)
            continue;
        struct line line = EMPTY_LINE;
        line_text(&line, switches > 100 ? "toggles " : "too few switches, toggles ");
        line_decimal(&line, toggles);
        line_text(&line, "\r\n");
        print(line.text);
    }
}

static void rest(void)
{
    for (;;) {
        WFI();
        irq_disable();
        switch_task();
        irq_enable();
    }
}

// The stack as if the task had just been switched away before its first instruction.
static void create(struct task *task, uint64_t *stack, void (*body)(void))
{
    uint32_t *frame = (uint32_t *)stack + STACK_WORDS - 16;
    frame[14] = (uint32_t)(uintptr_t)body & ~1u;
    frame[15] = 1u << 24; // Thumb
    task->sp = frame;
}

void SysTick_Handler(void) { ++tick; }

// Thread mode goes on with the process stack, as the idle task.
static __attribute__((naked)) void become_idle(uint64_t *stack_top, void (*body)(void))
{
    (void)stack_top;
    (void)body;
    __asm volatile("msr psp, r0\n mov r2, #2\n msr control, r2\n isb\n bx r1");
}

int main(void)
{
    clock_72mhz();
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_GPIOC | RCC_APB2_USART1;
    pin_write(GPIOC, LED, true);
    pin_mode(GPIOC, LED, PIN_OUTPUT);
    pin_mode(GPIOA, 0, PIN_OUTPUT);
    pin_mode(GPIOA, 1, PIN_OUTPUT);
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE;
    create(&fast, stacks[0], blink_fast);
    create(&slow, stacks[1], blink_slow);
    SYSTICK->LOAD = clock_hclk_hz() / 1000 - 1;
    SYSTICK->VAL = 0;
    SYSTICK->CTRL = SYSTICK_CLKSOURCE | SYSTICK_TICKINT | SYSTICK_ENABLE;
    become_idle(&stacks[2][STACK_WORDS / 2], rest);
    __builtin_unreachable();
}
