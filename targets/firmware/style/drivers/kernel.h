// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of a kernel for devices: threads by priority on lists, semaphores with a limit of time that interrupts may give,
// work that interrupts leave to a thread, one wrapper for all interrupts, and no tick: SysTick counts to the next deadline.

#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "chip/irq.h"

#define E_IO (-5)
#define E_AGAIN (-11) // the time was over
#define FOREVER (-1)

struct thread {
    uint32_t *sp; // first: the switch finds it at offset 0
    struct thread *next, **list;
    uint32_t priority; // the smaller, the more urgent
    uint64_t deadline; // in cycles; 0 for none
    int result;        // of what it has waited for
};

struct sem {
    uint32_t count, limit;
    struct thread *waiters;
};

#define SEM(count_, limit_) ((struct sem){.count = (count_), .limit = (limit_)})

struct work {
    void (*handler)(struct work *work);
    struct work *next;
    bool pending;
};

void thread_create(struct thread *thread, uint64_t *stack, uint32_t stack_bytes, void (*body)(void), uint32_t priority);
void kernel_start(void (*body)(void)) __attribute__((noreturn)); // `body` is the most urgent thread of all

void sem_give(struct sem *sem);
int sem_take(struct sem *sem, int32_t limit_ms); // 0, or E_AGAIN
void sleep_ms(uint32_t ms);
uint64_t uptime_ms(void);
void work_submit(struct work *work);

void irq_connect(enum irq irq, void (*handler)(const void *argument), const void *argument);
