// SPDX-License-Identifier: GPL-2.0-or-later

#include "vehicle_interface/kernel/kernel.h"

#include <stdbool.h>

#include "chip/core.h"
#include "chip/cpu.h"
#include "vehicle_interface/chip/irq.h"

#define EXCEPTION_PENDSV 14
#define EXCEPTION_SYSTICK 15
#define THREAD_ON_PSP 0xFFFFFFFDu // EXC_RETURN without floating-point registers
#define XPSR_THUMB (1u << 24)

static struct task idle = {.state = TASK_READY};
static struct task *tasks = &idle; // the most urgent first
static volatile uint32_t tick;

struct task *kernel_current = &idle;
struct task *kernel_choose(void);

// --- Guarding kernel data

static uint32_t lock(void)
{
    uint32_t before = READ_SPECIAL("basepri");
    WRITE_SPECIAL("basepri", KERNEL_LEVEL << 4);
    return before;
}

static void unlock(uint32_t before) { WRITE_SPECIAL("basepri", before); }

void kernel_lock(void) { lock(); }

void kernel_unlock(void) { unlock(0); }

// --- The switch

static void ask_for_switch(void) { SCB->ICSR = ICSR_PENDSVSET; }

// Somebody is always ready, and be it idle, which is last.
struct task *kernel_choose(void)
{
    struct task *task = tasks;
    while (task->state != TASK_READY)
        task = task->next;
    kernel_current = task;
    return task;
}

// The core has pushed the caller-saved registers on the task's stack; the rest goes there too, and EXC_RETURN, whose bit 4
// says whether the frame has floating-point registers.
__attribute__((naked)) void PendSV_Handler(void)
{
    __asm volatile("mrs r0, psp\n"
                   "tst lr, #0x10\n"
                   "it eq\n"
                   "vstmdbeq r0!, {s16-s31}\n"
                   "stmdb r0!, {r4-r11, lr}\n"
                   "ldr r1, =kernel_current\n"
                   "ldr r1, [r1]\n"
                   "str r0, [r1]\n"
                   "mov r0, %0\n"
                   "msr basepri, r0\n" // the list may not change while one is chosen
                   "isb\n"
                   "bl kernel_choose\n"
                   "mov r1, #0\n"
                   "msr basepri, r1\n"
                   "ldr r0, [r0]\n"
                   "ldmia r0!, {r4-r11, lr}\n"
                   "tst lr, #0x10\n"
                   "it eq\n"
                   "vldmiaeq r0!, {s16-s31}\n"
                   "msr psp, r0\n"
                   "bx lr\n"
                   ".ltorg" ::"i"(KERNEL_LEVEL << 4));
}

// --- Tasks

// The stack as if the task had just been interrupted before its first instruction: r4 to r11 and EXC_RETURN, then r0 to r3,
// r12, lr, pc and xPSR.
void task_create(struct task *task, uint64_t *stack, uint32_t bytes, void (*body)(void), uint32_t priority)
{
    uint32_t *frame = (uint32_t *)stack + bytes / 4 - 17;
    for (int i = 0; i < 17; ++i)
        frame[i] = 0;
    frame[8] = THREAD_ON_PSP;
    frame[15] = (uint32_t)(uintptr_t)body & ~1u;
    frame[16] = XPSR_THUMB;
    struct task **place = &tasks;
    while ((*place)->priority >= priority && *place != &idle)
        place = &(*place)->next;
    *task = (struct task){.sp = frame, .next = *place, .priority = priority, .state = TASK_READY};
    *place = task;
}

// main goes on as the idle task, on the stack it has; interrupts get the other one.
void kernel_start(uint32_t core_hz, uint64_t *interrupt_stack_top)
{
    SCB->SHPR[EXCEPTION_PENDSV - 4] = LEVEL_PENDSV << 4;
    SCB->SHPR[EXCEPTION_SYSTICK - 4] = LEVEL_TICK << 4;
    __asm volatile("mov r0, sp\n"
                   "msr psp, r0\n"
                   "mov r0, #2\n" // thread mode takes PSP
                   "msr control, r0\n"
                   "isb\n"
                   "msr msp, %0\n" ::"r"(interrupt_stack_top)
                   : "r0", "memory");
    SYSTICK->LOAD = core_hz / TICK_HZ - 1;
    SYSTICK->VAL = 0;
    SYSTICK->CTRL = SYSTICK_CLKSOURCE | SYSTICK_TICKINT | SYSTICK_ENABLE;
    ask_for_switch();
    for (;;)
        WFI();
}

// --- Waiting and waking

static uint32_t satisfied(const struct events *events, uint32_t wanted, enum events_how how)
{
    uint32_t there = events->bits & wanted;
    return how == EVENTS_ANY || there == wanted ? there : 0;
}

static void wake(struct task *task, uint32_t taken)
{
    task->taken = taken;
    task->events = 0;
    task->state = TASK_READY;
    ask_for_switch();
}

// The switch comes when the lock is let go.
static void wait(struct events *events, uint32_t wanted, enum events_how how, uint32_t timeout)
{
    struct task *me = kernel_current;
    me->events = events;
    me->wanted = wanted;
    me->how = how;
    me->timeout = timeout;
    me->wake_tick = tick + timeout;
    me->state = TASK_WAITING;
    ask_for_switch();
}

uint32_t kernel_tick(void) { return tick; }

void SysTick_Handler(void)
{
    uint32_t before = lock();
    ++tick;
    for (struct task *task = tasks; task; task = task->next)
        if (task->state == TASK_WAITING && task->timeout != FOR_EVER && (int32_t)(tick - task->wake_tick) >= 0)
            wake(task, 0);
    unlock(before);
}

void task_delay(uint32_t ticks)
{
    if (ticks == 0)
        return;
    uint32_t before = lock();
    wait(0, 0, EVENTS_ANY, ticks);
    unlock(before);
}

void events_set(struct events *events, uint32_t bits)
{
    uint32_t before = lock();
    events->bits |= bits;
    for (struct task *task = tasks; task; task = task->next) {
        if (task->state != TASK_WAITING || task->events != events)
            continue;
        uint32_t taken = satisfied(events, task->wanted, task->how);
        if (taken) {
            events->bits &= ~taken;
            wake(task, taken);
        }
    }
    unlock(before);
}

uint32_t events_wait(struct events *events, uint32_t bits, enum events_how how, uint32_t timeout_ticks)
{
    uint32_t before = lock();
    uint32_t taken = satisfied(events, bits, how);
    events->bits &= ~taken;
    if (taken || timeout_ticks == 0) {
        unlock(before);
        return taken;
    }
    wait(events, bits, how, timeout_ticks);
    unlock(before);
    return kernel_current->taken;
}
