// SPDX-License-Identifier: GPL-2.0-or-later
//
// A small preemptive kernel: tasks of fixed priorities, a tick of 1 ms, and events that tasks wait for and that tasks and
// interrupts set.
//
//   - main becomes the idle task, which sleeps whenever nobody else is ready.
//   - The switch itself is PendSV at the lowest level, so it never comes between nested interrupts (DDI 0403, B1.5).
//   - Kernel data is guarded by BASEPRI: interrupts more urgent than KERNEL_LEVEL are never held up, and may not call us.
//   - A task that has used the floating-point unit takes its registers along; the core leaves room for them when it takes an
//     exception, and fills it only if they are used meanwhile (lazy stacking, DDI 0403, B1.5.7).

#pragma once

#include <stdint.h>

#define KERNEL_LEVEL 5u // interrupts of this level and below (5 to 15) may call events_set
#define TICK_HZ 1000u
#define FOR_EVER 0xFFFFFFFFu

// Bits that stay set until somebody takes them.
struct events {
    uint32_t bits;
};

enum events_how { EVENTS_ANY, EVENTS_ALL };

struct task {
    uint32_t *sp; // first: the switch finds it there
    struct task *next;
    uint32_t priority; // the greater, the more urgent
    enum { TASK_READY, TASK_WAITING } state;
    uint32_t wake_tick; // if it does not wait for ever
    uint32_t timeout;   // in ticks, as it was asked for
    struct events *events; // it waits for, or none
    uint32_t wanted;
    enum events_how how;
    uint32_t taken;
};

// A stack is `bytes` of whole double words; a task never returns.
void task_create(struct task *task, uint64_t *stack, uint32_t bytes, void (*body)(void), uint32_t priority);

// Starts the tasks, with interrupts on a stack of their own. Does not return.
void kernel_start(uint32_t core_hz, uint64_t *interrupt_stack_top) __attribute__((noreturn));

// The number of ticks so far.
uint32_t kernel_tick(void);

// Until the tick that is so many from now.
void task_delay(uint32_t ticks);

// From tasks and interrupts.
void events_set(struct events *events, uint32_t bits);

// Takes those of `bits` that are set: as soon as any or all of them are, or, when so many ticks have passed, none: then 0 is
// returned.
uint32_t events_wait(struct events *events, uint32_t bits, enum events_how how, uint32_t timeout_ticks);

// Between these two neither a switch nor an interrupt that knows the kernel comes. They do not nest.
void kernel_lock(void);
void kernel_unlock(void);
