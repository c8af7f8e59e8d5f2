// SPDX-License-Identifier: GPL-2.0-or-later

#include "kernel.h"

#include "chip/stm32f103.h"
#include "handlers.h"

#define THREADS 8u
#define LOCKED 0x10u // BASEPRI
#define IRQ_LEVEL 2u
#define IDLE_PRIORITY 100u
#define WORK_PRIORITY 1u
#define CYCLES_MS 72000u
#define LONGEST 0x00FFFFFFu
#define SHORTEST 500u // so that it is not over before it was begun

static uint32_t irq_lock(void)
{
    uint32_t key = READ_SPECIAL("basepri");
    WRITE_SPECIAL("basepri_max", LOCKED);
    return key;
}

static void irq_unlock(uint32_t key) { WRITE_SPECIAL("basepri", key); }

// --- Interrupts: all come through one wrapper, which looks up who they are for

static struct {
    void (*handler)(const void *argument);
    const void *argument;
} isr_table[IRQ_COUNT];

static __attribute__((used)) void isr_wrapper(void)
{
    uint32_t irq = READ_SPECIAL("ipsr") - 16;
    isr_table[irq].handler(isr_table[irq].argument);
}

#define WRAPPED(name) void name(void) __attribute__((alias("isr_wrapper")));
IRQ_HANDLERS(WRAPPED)

void irq_connect(enum irq irq, void (*handler)(const void *argument), const void *argument)
{
    isr_table[irq].handler = handler;
    isr_table[irq].argument = argument;
    irq_priority(irq, IRQ_LEVEL);
    irq_line_enable(irq);
}

// --- Threads: the one that runs is the first that is ready

static struct thread *ready, *threads[THREADS], idle_thread, main_thread;
static struct thread *current __attribute__((used)); // by the switch
static uint32_t thread_count;
static uint64_t idle_stack[32], main_stack[64];

static void insert(struct thread *thread, struct thread **list)
{
    thread->list = list;
    while (*list && (*list)->priority <= thread->priority)
        list = &(*list)->next;
    thread->next = *list;
    *list = thread;
}

static void take_out(struct thread *thread)
{
    struct thread **at = thread->list;
    while (*at != thread)
        at = &(*at)->next;
    *at = thread->next;
}

static void make_ready(struct thread *thread, int result)
{
    thread->deadline = 0;
    thread->result = result;
    insert(thread, &ready);
    if (ready != current)
        SCB->ICSR = ICSR_PENDSVSET;
}

// It comes as soon as BASEPRI lets it; one load decides.
__attribute__((naked)) void PendSV_Handler(void)
{
    __asm volatile("mrs r0, psp\n"
                   "stmdb r0!, {r4-r11}\n"
                   "ldr r1, =current\n"
                   "ldr r2, [r1]\n"
                   "str r0, [r2]\n"
                   "ldr r2, =ready\n"
                   "ldr r2, [r2]\n"
                   "str r2, [r1]\n"
                   "ldr r0, [r2]\n"
                   "ldmia r0!, {r4-r11}\n"
                   "msr psp, r0\n"
                   "bx lr\n"
                   ".ltorg");
}

static void ended(void)
{
    for (;;)
        sleep_ms(1000);
}

void thread_create(struct thread *thread, uint64_t *stack, uint32_t stack_bytes, void (*body)(void), uint32_t priority)
{
    uint32_t *frame = (uint32_t *)stack + stack_bytes / 4 - 16;
    frame[13] = (uint32_t)(uintptr_t)ended;
    frame[14] = (uint32_t)(uintptr_t)body & ~1u;
    frame[15] = 1u << 24; // Thumb
    *thread = (struct thread){.sp = frame, .priority = priority};
    threads[thread_count++] = thread;
    uint32_t key = irq_lock();
    make_ready(thread, 0);
    irq_unlock(key);
}

// --- Time: cycles up to the last load of SysTick, and those since

static uint64_t loaded_at;
static uint32_t load = LONGEST, wrapped;

static uint64_t cycles_now(void)
{
    uint32_t before = SYSTICK->VAL, control = SYSTICK->CTRL, left = SYSTICK->VAL;
    if (control & SYSTICK_COUNTFLAG || before < left) {
        wrapped += load;
        (void)SYSTICK->CTRL; // a wrap between the two reads of VAL is counted once
    }
    return loaded_at + wrapped + (load - 1 - left);
}

static void set_alarm(void)
{
    uint64_t now = cycles_now(), next = now + LONGEST;
    for (uint32_t at = 0; at < thread_count; ++at)
        if (threads[at]->deadline && threads[at]->deadline < next)
            next = threads[at]->deadline;
    loaded_at = now;
    wrapped = 0;
    load = next < now + SHORTEST ? SHORTEST : (uint32_t)(next - now);
    SYSTICK->LOAD = load - 1;
    SYSTICK->VAL = 0;
}

void SysTick_Handler(void)
{
    uint32_t key = irq_lock();
    uint64_t now = cycles_now();
    for (uint32_t at = 0; at < thread_count; ++at)
        if (threads[at]->deadline && threads[at]->deadline <= now) {
            take_out(threads[at]);
            make_ready(threads[at], E_AGAIN);
        }
    set_alarm();
    irq_unlock(key);
}

uint64_t uptime_ms(void)
{
    uint32_t key = irq_lock();
    uint64_t now = cycles_now();
    irq_unlock(key);
    return now / CYCLES_MS;
}

// --- Waiting

static int wait_on(struct thread **list, int32_t limit_ms, uint32_t key)
{
    struct thread *self = current;
    take_out(self);
    insert(self, list);
    if (limit_ms != FOREVER) {
        self->deadline = cycles_now() + (uint64_t)limit_ms * CYCLES_MS;
        set_alarm();
    }
    SCB->ICSR = ICSR_PENDSVSET;
    irq_unlock(0); // the switch
    irq_unlock(key);
    return self->result;
}

void sleep_ms(uint32_t ms)
{
    static struct thread *sleepers;
    uint32_t key = irq_lock();
    wait_on(&sleepers, (int32_t)ms, key);
}

int sem_take(struct sem *sem, int32_t limit_ms)
{
    uint32_t key = irq_lock();
    if (!sem->count)
        return wait_on(&sem->waiters, limit_ms, key);
    --sem->count;
    irq_unlock(key);
    return 0;
}

void sem_give(struct sem *sem)
{
    uint32_t key = irq_lock();
    struct thread *first = sem->waiters;
    if (first) {
        take_out(first);
        make_ready(first, 0);
    } else if (sem->count < sem->limit) {
        ++sem->count;
    }
    irq_unlock(key);
}

// --- Work

static struct thread work_thread;
static uint64_t work_stack[64];
static struct work *works;
static struct sem work_there = {.limit = THREADS};

void work_submit(struct work *work)
{
    uint32_t key = irq_lock();
    if (!work->pending) {
        struct work **at = &works;
        while (*at)
            at = &(*at)->next;
        work->next = 0;
        work->pending = true;
        *at = work;
        sem_give(&work_there);
    }
    irq_unlock(key);
}

static void work_body(void)
{
    for (;;) {
        sem_take(&work_there, FOREVER);
        uint32_t key = irq_lock();
        struct work *work = works;
        works = work->next;
        work->pending = false;
        irq_unlock(key);
        work->handler(work);
    }
}

// --- The start, and what is done when nobody has anything to do

// With PRIMASK set an interrupt ends WFI without being taken, so that none is missed between the two.
static void idle_body(void)
{
    for (;;) {
        irq_disable();
        DSB();
        WFI();
        irq_enable();
        ISB();
    }
}

// From the stack of interrupts to the thread's own; nothing comes back.
__attribute__((naked, noreturn)) static void
go_on_at(__attribute__((unused)) uint64_t *stack_end, __attribute__((unused)) void (*body)(void))
{
    __asm volatile("msr psp, r0\n"
                   "mov r2, #2\n"
                   "msr control, r2\n"
                   "isb\n"
                   "cpsie i\n"
                   "blx r1\n");
}

void kernel_start(void (*body)(void))
{
    irq_disable();
    exception_priority(EXCEPTION_PENDSV, 15);
    exception_priority(EXCEPTION_SYSTICK, IRQ_LEVEL);
    current = &main_thread;
    threads[thread_count++] = current;
    insert(current, &ready);
    thread_create(&idle_thread, idle_stack, sizeof idle_stack, idle_body, IDLE_PRIORITY);
    thread_create(&work_thread, work_stack, sizeof work_stack, work_body, WORK_PRIORITY);
    SYSTICK->LOAD = load - 1;
    SYSTICK->VAL = 0;
    SYSTICK->CTRL = SYSTICK_CLKSOURCE | SYSTICK_TICKINT | SYSTICK_ENABLE;
    go_on_at(main_stack + sizeof main_stack / sizeof *main_stack, body);
}
