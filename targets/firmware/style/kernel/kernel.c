// SPDX-License-Identifier: GPL-2.0-or-later

#include "kernel.h"

#include "chip/stm32f103.h"
#include "handlers.h"

static struct task *tasks[MAX_TASKS];
static uint32_t task_count;
static volatile uint32_t tick;

struct task *kernel_current; // also known to the switch

// --- Guarding

uint32_t kernel_enter(void)
{
    uint32_t before = READ_SPECIAL("basepri");
    WRITE_SPECIAL("basepri_max", KERNEL_LEVEL << 4);
    return before;
}

void kernel_leave(uint32_t before) { WRITE_SPECIAL("basepri", before); }

static void request_switch(void) { SCB->ICSR = ICSR_PENDSVSET; }

// --- The switch

struct task *kernel_choose(struct task *current);

// The most urgent that is ready; of equals, the next after the present one.
struct task *kernel_choose(struct task *current)
{
    uint32_t start = 0;
    while (start < task_count && tasks[start] != current)
        ++start;
    struct task *best = 0;
    for (uint32_t i = 1; i <= task_count; ++i) {
        struct task *task = tasks[(start + i) % task_count];
        if (task->state == TASK_READY && (!best || task->priority > best->priority))
            best = task;
    }
    if (best != current)
        ++best->switches;
    return best;
}

// The core has pushed the caller-saved registers on the task's stack; the rest goes there too.
__attribute__((naked)) void PendSV_Handler(void)
{
    __asm volatile("mrs r0, psp\n"
                   "stmdb r0!, {r4-r11}\n"
                   "ldr r4, =kernel_current\n"
                   "ldr r1, [r4]\n"
                   "str r0, [r1]\n"
                   "mov r5, %0\n"
                   "msr basepri, r5\n" // the lists may not change while one is chosen
                   "mov r0, r1\n"
                   "mov r6, lr\n"
                   "bl kernel_choose\n"
                   "mov lr, r6\n"
                   "str r0, [r4]\n"
                   "ldr r1, [r0]\n"
                   "mov r5, #0\n"
                   "msr basepri, r5\n"
                   "ldmia r1!, {r4-r11}\n"
                   "msr psp, r1\n"
                   "bx lr\n"
                   ".ltorg" ::"i"(KERNEL_LEVEL << 4));
}

// SVC 0 never returns to its caller: the stack of main is given up.
__attribute__((naked)) static void start_first(void)
{
    __asm volatile("ldr r0, =kernel_current\n"
                   "ldr r0, [r0]\n"
                   "ldr r1, [r0]\n"
                   "ldmia r1!, {r4-r11}\n"
                   "msr psp, r1\n"
                   "mvn lr, #2\n" // 0xFFFFFFFD: thread mode, process stack
                   "bx lr\n"
                   ".ltorg");
}

__attribute__((naked)) void SVC_Handler(void)
{
    __asm volatile("tst lr, #4\n"
                   "ite eq\n"
                   "mrseq r0, msp\n"
                   "mrsne r0, psp\n"
                   "ldr r0, [r0, #24]\n"
                   "ldrb r0, [r0, #-2]\n" // the number in the instruction
                   "cbnz r0, 1f\n"
                   "b %0\n"
                   "1: ldr r0, =0xE000ED04\n" // SCB_ICSR
                   "mov r1, #1 << 28\n"       // PENDSVSET
                   "str r1, [r0]\n"
                   "bx lr\n"
                   ".ltorg" ::"i"(start_first));
}

void task_yield(void) { __asm volatile("svc #1" ::: "memory"); }

// --- Tasks

static void task_returned(void)
{
    for (;;) {
    }
}

// The stack as if the task had just been interrupted before its first instruction.
void task_create(struct task *task, uint64_t *stack, uint32_t stack_bytes, void (*body)(void *), void *argument,
                 uint32_t priority)
{
    uint32_t *frame = (uint32_t *)stack + stack_bytes / 4 - 16;
    for (int i = 0; i < 16; ++i)
        frame[i] = 0;
    frame[8] = (uint32_t)(uintptr_t)argument;
    frame[13] = (uint32_t)(uintptr_t)task_returned;
    frame[14] = (uint32_t)(uintptr_t)body & ~1u;
    frame[15] = 1u << 24; // Thumb
    *task = (struct task){.sp = frame, .priority = priority, .base_priority = priority, .state = TASK_READY};
    tasks[task_count++] = task;
}

void kernel_start(uint32_t hclk_hz)
{
    exception_priority(EXCEPTION_PENDSV, 15);
    exception_priority(EXCEPTION_SYSTICK, 14);
    exception_priority(EXCEPTION_SVCALL, 0);
    SYSTICK->LOAD = hclk_hz / 1000 - 1;
    SYSTICK->VAL = 0;
    kernel_current = kernel_choose(0);
    SYSTICK->CTRL = SYSTICK_CLKSOURCE | SYSTICK_TICKINT | SYSTICK_ENABLE;
    __asm volatile("svc #0");
    __builtin_unreachable();
}

// --- Time

uint32_t kernel_tick(void) { return tick; }

void SysTick_Handler(void)
{
    uint32_t before = kernel_enter();
    bool woken = false;
    ++tick;
    for (uint32_t i = 0; i < task_count; ++i) {
        struct task *task = tasks[i];
        if (task->state == TASK_ASLEEP && (int32_t)(tick - task->wake_tick) >= 0) {
            task->state = TASK_READY;
            woken = true;
        }
    }
    kernel_leave(before);
    if (woken)
        request_switch();
}

void task_sleep_until(uint32_t wake_tick)
{
    uint32_t before = kernel_enter();
    if ((int32_t)(tick - wake_tick) < 0) {
        kernel_current->wake_tick = wake_tick;
        kernel_current->state = TASK_ASLEEP;
        request_switch(); // happens when BASEPRI is let go
    }
    kernel_leave(before);
}

// --- Waiting for something and waking those who do

static void wait_for(const void *what)
{
    kernel_current->state = TASK_WAITING;
    kernel_current->waiting_for = what;
    request_switch();
}

static void wake_for(const void *what)
{
    for (uint32_t i = 0; i < task_count; ++i)
        if (tasks[i]->state == TASK_WAITING && tasks[i]->waiting_for == what) {
            tasks[i]->state = TASK_READY;
            request_switch();
        }
}

void mutex_lock(struct mutex *mutex)
{
    uint32_t before = kernel_enter();
    while (mutex->owner) {
        if (mutex->owner->priority < kernel_current->priority)
            mutex->owner->priority = kernel_current->priority; // or one in between could hold us both up
        wait_for(mutex);
        kernel_leave(before); // the switch
        before = kernel_enter();
    }
    mutex->owner = kernel_current;
    kernel_leave(before);
}

void mutex_unlock(struct mutex *mutex)
{
    uint32_t before = kernel_enter();
    mutex->owner->priority = mutex->owner->base_priority;
    mutex->owner = 0;
    wake_for(mutex);
    kernel_leave(before);
}

bool queue_send_from_isr(struct queue *queue, uint32_t item)
{
    uint32_t before = kernel_enter();
    bool room = queue->head - queue->tail < queue->capacity;
    if (room) {
        queue->items[queue->head++ % queue->capacity] = item;
        wake_for(queue);
    }
    kernel_leave(before);
    return room;
}

uint32_t queue_receive(struct queue *queue)
{
    uint32_t before = kernel_enter();
    while (queue->head == queue->tail) {
        wait_for(queue);
        kernel_leave(before);
        before = kernel_enter();
    }
    uint32_t item = queue->items[queue->tail++ % queue->capacity];
    kernel_leave(before);
    return item;
}
