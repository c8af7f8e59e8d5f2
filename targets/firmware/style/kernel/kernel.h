// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: a small preemptive kernel. Fixed priorities, tasks on the process stack, a tick of 1 ms, mutexes with
// priority inheritance, queues that interrupts may send to.
//
//   - The switch itself is PendSV at the lowest priority, so it never comes between nested interrupts (PM0056, 2.3.8).
//   - Kernel data is guarded by BASEPRI: interrupts more urgent than KERNEL_LEVEL are never held up, and may not call us.
//   - SVC 0 starts the first task, SVC 1 yields.

#pragma once

#include <stdbool.h>
#include <stdint.h>

#define KERNEL_LEVEL 5u // interrupts of this priority and below (6 .. 15) may call kernel_*_from_isr
#define MAX_TASKS 8

struct task {
    uint32_t *sp; // first: the switch finds it at offset 0
    uint32_t priority, base_priority; // the greater, the more urgent
    uint32_t wake_tick;
    enum { TASK_READY, TASK_ASLEEP, TASK_WAITING } state;
    const void *waiting_for;
    uint32_t switches; // times it was switched to
};

struct mutex {
    struct task *owner;
};

struct queue {
    uint32_t *items;
    uint32_t capacity, head, tail;
};

void task_create(struct task *task, uint64_t *stack, uint32_t stack_bytes, void (*body)(void *), void *argument,
                 uint32_t priority);
void kernel_start(uint32_t hclk_hz) __attribute__((noreturn));
uint32_t kernel_tick(void);

void task_yield(void);
void task_sleep_until(uint32_t tick);

void mutex_lock(struct mutex *mutex);
void mutex_unlock(struct mutex *mutex);

bool queue_send_from_isr(struct queue *queue, uint32_t item); // false when it is full
uint32_t queue_receive(struct queue *queue);

uint32_t kernel_enter(void); // raises BASEPRI, returns what it was
void kernel_leave(uint32_t before);
