// SPDX-License-Identifier: GPL-2.0-or-later
//
// Interrupts: enabling, pending, priorities, nesting, masks, the frame on the stack, sleep (DDI 0403, B1.5 and B3.4; PM0056, 4.3).
// All interrupts are pended by software, so that no peripheral has a part in it. Faults are in selftest/faults.c.

#include "check.h"
#include "chip/stm32f103.h"
#include "handlers.h"
#include "startup.h"

// --- Three interrupts whose handlers do what a test tells them and leave a trace of hexadecimal digits

static const enum irq A = EXTI0_IRQ, B = EXTI1_IRQ, D = EXTI2_IRQ;

static volatile uint32_t trace;
static void (*volatile in_a)(void);
static void (*volatile in_b)(void);

static void mark(uint32_t digit) { trace = trace << 4 | digit; }

// Digit 1, 2 or 3 on entry and 0xA, 0xB or 0xD on exit.
void EXTI0_IRQHandler(void)
{
    mark(1);
    if (in_a)
        in_a();
    mark(0xA);
}

void EXTI1_IRQHandler(void)
{
    mark(2);
    if (in_b)
        in_b();
    mark(0xB);
}

void EXTI2_IRQHandler(void)
{
    mark(3);
    mark(0xD);
}

static void set_up(unsigned priority_a, unsigned priority_b, unsigned priority_d)
{
    trace = 0;
    in_a = in_b = 0;
    irq_priority(A, priority_a);
    irq_priority(B, priority_b);
    irq_priority(D, priority_d);
    irq_line_enable(A);
    irq_line_enable(B);
    irq_line_enable(D);
}

static void pend_now(enum irq irq)
{
    irq_pend(irq);
    DSB(); // the write reaches the NVIC, and
    ISB(); // nothing after it runs before the interrupt (B1.5.4)
}

static void pend_all(void)
{
    irq_pend(A);
    irq_pend(B);
    irq_pend(D);
}

// --- What is there

static void identity(void)
{
    check_equal("cpuid-is-cortex-m3-r1p1", SCB->CPUID, 0x411FC231);
    check_equal("ictr-says-33-to-64-lines", ICTR & 0xF, 1);
    irq_priority(A, 0);
    NVIC->IPR[A] = 0xFF;
    check_equal("priority-has-4-bits", NVIC->IPR[A], 0xF0);
    SCB->SHPR[EXCEPTION_PENDSV - 4] = 0xFF;
    check_equal("system-priority-has-4-bits", SCB->SHPR[EXCEPTION_PENDSV - 4], 0xF0);
    SCB->SHPR[EXCEPTION_PENDSV - 4] = 0;
    NVIC->ISER[1] = 0xFFFFFFFF;
    check_equal("iser-has-43-lines", NVIC->ISER[1], 0x7FF);
    NVIC->ICER[1] = 0xFFFFFFFF;
    check_equal("icer-clears", NVIC->ISER[1], 0);
    check_equal("aircr-key-reads-fa05", SCB->AIRCR >> 16, 0xFA05);
    SCB->AIRCR = 5u << AIRCR_PRIGROUP_SHIFT;
    check_equal("aircr-without-key-is-ignored", SCB->AIRCR >> AIRCR_PRIGROUP_SHIFT & 7, 0);
}

// --- Enable and pend

static void see_state(void)
{
    check("iabr-in-handler", irq_is_active(A));
    check("not-pending-in-handler", !irq_is_pending(A));
    check_equal("ipsr-in-handler", READ_SPECIAL("ipsr"), 16 + A);
    check_equal("vectactive-in-handler", SCB->ICSR & ICSR_VECTACTIVE, 16 + A);
    check("rettobase-in-only-handler", SCB->ICSR & ICSR_RETTOBASE);
}

static void pend_self_once(void)
{
    static bool done;
    if (!done)
        irq_pend(A);
    done = true;
}

static void pending(void)
{
    set_up(0, 0, 0);
    irq_line_disable(A);
    pend_now(A);
    check_equal("disabled-is-not-taken", trace, 0);
    check("disabled-stays-pending", irq_is_pending(A));
    irq_unpend(A);
    check("icpr-unpends", !irq_is_pending(A));
    irq_pend(A);
    irq_line_enable(A);
    DSB();
    ISB();
    check_equal("taken-when-enabled", trace, 0x1A);
    check("not-active-after-return", !irq_is_active(A));

    set_up(0, 0, 0);
    in_a = see_state;
    pend_now(A);
    set_up(0, 0, 0);
    in_a = pend_self_once;
    pend_now(A);
    check_equal("pended-in-itself-runs-again", trace, 0x1A1A);

    set_up(0, 0, 0);
    STIR = B;
    DSB();
    ISB();
    check_equal("stir-pends", trace, 0x2B);
}

// --- Order and nesting

static void pend_b(void) { pend_now(B); }

static void pend_b_and_see(void)
{
    pend_now(B);
    check("rettobase-after-nested", SCB->ICSR & ICSR_RETTOBASE);
}

static void see_nesting(void) { check("no-rettobase-when-nested", !(SCB->ICSR & ICSR_RETTOBASE)); }

static void order(void)
{
    set_up(3, 2, 1);
    irq_disable();
    pend_all();
    check("isrpending", SCB->ICSR & ICSR_ISRPENDING);
    check_equal("vectpending-ignores-primask", SCB->ICSR >> ICSR_VECTPENDING_SHIFT & 0x1FF, 16 + D);
    irq_enable();
    ISB();
    check_equal("order-by-priority", trace, 0x3D2B1A);

    set_up(5, 5, 5);
    irq_disable();
    pend_all();
    irq_enable();
    ISB();
    check_equal("order-by-number", trace, 0x1A2B3D);

    set_up(5, 4, 5);
    in_a = pend_b_and_see;
    in_b = see_nesting;
    pend_now(A);
    check_equal("higher-preempts", trace, 0x12BA);

    set_up(5, 5, 5);
    in_a = pend_b;
    pend_now(A);
    check_equal("equal-does-not-preempt", trace, 0x1A2B);

    // Group priority: with PRIGROUP 5 bits 7:6 preempt, bits 5:4 only order (B1.5.4)
    SCB->AIRCR = AIRCR_VECTKEY | 5u << AIRCR_PRIGROUP_SHIFT;
    check_equal("prigroup-is-kept", SCB->AIRCR >> AIRCR_PRIGROUP_SHIFT & 7, 5);
    set_up(6, 5, 4);
    in_a = pend_b;
    pend_now(A);
    check_equal("subpriority-does-not-preempt", trace, 0x1A2B);
    trace = 0;
    in_a = 0;
    irq_disable();
    pend_all();
    irq_enable();
    ISB();
    check_equal("subpriority-orders", trace, 0x3D2B1A);
    set_up(6, 3, 4);
    in_a = pend_b;
    pend_now(A);
    check_equal("group-preempts", trace, 0x12BA);
    SCB->AIRCR = AIRCR_VECTKEY;
}

// --- Masks

static volatile uint32_t nmis;

void NMI_Handler(void) { ++nmis; }

static void mask_all_but_nmi(void)
{
    WRITE_SPECIAL("faultmask", 1);
    pend_now(A);
    check_equal("faultmask-holds", trace, 0);
    SCB->ICSR = ICSR_NMIPENDSET;
    DSB();
    ISB();
    check_equal("faultmask-lets-nmi", nmis, 1);
    WRITE_SPECIAL("faultmask", 0);
    check_equal("faultmask-released", trace, 0x1A);
}

static void drop_faultmask(void) { WRITE_SPECIAL("faultmask", 1); }

static void masks(void)
{
    set_up(4, 5, 3);
    WRITE_SPECIAL("primask", 1);
    pend_now(A);
    check_equal("primask-holds", trace, 0);
    WRITE_SPECIAL("primask", 0);
    check_equal("primask-released", trace, 0x1A);

    set_up(4, 5, 3);
    WRITE_SPECIAL("basepri", 4 << 4);
    irq_pend(A);
    irq_pend(B);
    pend_now(D);
    check_equal("basepri-lets-more-urgent", trace, 0x3D);
    check_equal("vectpending-obeys-basepri", SCB->ICSR >> ICSR_VECTPENDING_SHIFT & 0x1FF, 0);
    WRITE_SPECIAL("basepri", 5 << 4);
    check_equal("basepri-raised", trace, 0x3D1A);
    WRITE_SPECIAL("basepri", 0);
    check_equal("basepri-0-holds-nothing", trace, 0x3D1A2B);

    set_up(0, 0, 0);
    mask_all_but_nmi();
    in_a = drop_faultmask;
    pend_now(A);
    check_equal("faultmask-ends-with-exception", READ_SPECIAL("faultmask"), 0); // B1.4.3
}

// --- Changing priority and enabling while pending

static void raise_b(void)
{
    irq_priority(B, 9);
    pend_now(B);
    mark(7);
    irq_priority(B, 1);
    DSB();
    ISB();
    mark(8);
}

static void changes(void)
{
    set_up(5, 9, 9);
    in_a = raise_b;
    pend_now(A);
    check_equal("raised-priority-preempts", trace, 0x172B8A);
    trace = 0;
    in_a = 0;
    irq_line_disable(A);
}

// --- System calls: SVC sees what the caller had (B1.5.6)

static struct {
    struct exception_frame frame;
    uint32_t address;
    uint32_t exc_return;
} call;

#define SVC_ADD 1
#define SVC_PRIVILEGE 2

void svc_body(struct exception_frame *frame, uint32_t exc_return);

void svc_body(struct exception_frame *frame, uint32_t exc_return)
{
    call.frame = *frame;
    call.address = (uint32_t)(uintptr_t)frame;
    call.exc_return = exc_return;
    switch (((const uint8_t *)(uintptr_t)frame->pc)[-2]) {
    case SVC_ADD:
        frame->r0 += frame->r1;
        break;
    case SVC_PRIVILEGE:
        WRITE_SPECIAL("control", READ_SPECIAL("control") & ~1u);
        break;
    default:
        break;
    }
}

__attribute__((naked)) void SVC_Handler(void)
{
    __asm volatile("tst lr, #4\n"
                   "ite eq\n"
                   "mrseq r0, msp\n"
                   "mrsne r0, psp\n"
                   "mov r1, lr\n"
                   "push {r1, lr}\n"
                   "bl svc_body\n"
                   "pop {r1, pc}");
}

static uint32_t add_by_svc(uint32_t a, uint32_t b)
{
    register uint32_t r0 __asm("r0") = a;
    register uint32_t r1 __asm("r1") = b;
    __asm volatile("mov r2, #0x22\n mov r3, #0x33\n mov r12, #0xCC\n svc %2"
                   : "+r"(r0)
                   : "r"(r1), "i"(SVC_ADD)
                   : "r2", "r3", "r12", "memory");
    return r0;
}

static void system_calls(void)
{
    check_equal("svc-returns-by-frame", add_by_svc(40, 2), 42);
    check_equal("frame-r0", call.frame.r0, 40);
    check_equal("frame-r1", call.frame.r1, 2);
    check_equal("frame-r2", call.frame.r2, 0x22);
    check_equal("frame-r3", call.frame.r3, 0x33);
    check_equal("frame-r12", call.frame.r12, 0xCC);
    check("frame-xpsr-has-t", call.frame.xpsr & 1u << 24);
    check_equal("frame-xpsr-ipsr-is-thread", call.frame.xpsr & 0x1FF, 0);
    check_equal("exc-return-thread-msp", call.exc_return, 0xFFFFFFF9);
}

// --- PendSV and SysTick pended by software

static volatile uint32_t pendsv_link;

void pendsv_body(uint32_t link);

void pendsv_body(uint32_t link)
{
    pendsv_link = link;
    mark(4);
}

__attribute__((naked)) void PendSV_Handler(void)
{
    __asm volatile("mov r0, lr\n push {r0, lr}\n bl pendsv_body\n pop {r0, pc}");
}

static volatile uint32_t ticks;
static volatile uint32_t sleep_until_tick;

void SysTick_Handler(void)
{
    ++ticks;
    mark(5);
    if (ticks >= sleep_until_tick) {
        SCB->SCR = 0;
        SYSTICK->CTRL = 0;
    }
}

static void pend_pendsv(void)
{
    SCB->ICSR = ICSR_PENDSVSET;
    DSB();
    ISB();
    check("pendsvset-reads-1", SCB->ICSR & ICSR_PENDSVSET);
}

static void pend_pendsv_and_drop(void)
{
    pend_pendsv();
    SCB->ICSR = ICSR_PENDSVCLR;
    check("pendsvclr", !(SCB->ICSR & ICSR_PENDSVSET));
}

static void system_exceptions(void)
{
    exception_priority(EXCEPTION_PENDSV, 15);
    exception_priority(EXCEPTION_SYSTICK, 0);
    set_up(5, 5, 5);
    in_a = pend_pendsv;
    pend_now(A);
    check_equal("pendsv-waits-for-handler", trace, 0x1A4);
    check_equal("tail-chained-exc-return-is-thread", pendsv_link, 0xFFFFFFF9);
    set_up(5, 5, 5);
    in_a = pend_pendsv_and_drop;
    pend_now(A);
    check_equal("pendsv-dropped", trace, 0x1A);
    set_up(5, 5, 5);
    sleep_until_tick = 0;
    SCB->ICSR = ICSR_PENDSTSET;
    DSB();
    ISB();
    check_equal("pendstset-runs-systick", trace, 5);
    exception_priority(EXCEPTION_PENDSV, 3);
    set_up(5, 5, 5);
    in_a = pend_pendsv;
    irq_priority(A, 2);
    pend_now(A);
    exception_priority(EXCEPTION_PENDSV, 15);
}

// --- Where a nested handler returns to, and that a tail-chained one shares the frame of the first (B1.5.12)

static volatile uint32_t link_seen[2], stack_seen[2], pc_seen[2];

void chained_body(uint32_t link, const struct exception_frame *frame);

void chained_body(uint32_t link, const struct exception_frame *frame)
{
    static uint32_t which;
    if (frame) {
        link_seen[which & 1] = link;
        stack_seen[which & 1] = (uint32_t)(uintptr_t)frame;
        pc_seen[which & 1] = frame->pc;
        if (which++ == 0)
            pend_now(EXTI4_IRQ);
    }
}

#define CHAINED __asm volatile("mov r0, lr\n mov r1, sp\n push {r0, lr}\n bl chained_body\n pop {r0, pc}")

__attribute__((naked)) void EXTI3_IRQHandler(void) { CHAINED; }
__attribute__((naked)) void EXTI4_IRQHandler(void) { CHAINED; }

static void chaining(void)
{
    irq_line_enable(EXTI3_IRQ);
    irq_line_enable(EXTI4_IRQ);
    pend_now(EXTI3_IRQ); // EXTI4, of the same priority, is pended in it
    check_equal("tail-chain-same-link", link_seen[1], link_seen[0]);
    check_equal("tail-chain-same-frame", stack_seen[1], stack_seen[0]);
    check_equal("tail-chain-no-instruction-between", pc_seen[1], pc_seen[0]);
}

static void svc_in_handler(void) { __asm volatile("svc #0" ::: "memory"); }

// --- The process stack, and the alignment of frames (B1.5.7)

static uint64_t process_stack[64];

// Calls `body` with SP being PSP, `offset` bytes below the top of the process stack.
static __attribute__((naked)) void on_process_stack(void (*body)(void), void *top)
{
    (void)body;
    (void)top;
    __asm volatile("push {r4, lr}\n"
                   "msr psp, r1\n"
                   "mrs r4, control\n"
                   "orr r1, r4, #2\n"
                   "msr control, r1\n"
                   "isb\n"
                   "blx r0\n"
                   "mrs r4, control\n" // still SPSEL; nPRIV as the body left it
                   "bic r4, #2\n"
                   "msr control, r4\n"
                   "isb\n"
                   "pop {r4, pc}");
}

static __attribute__((naked)) void plain_svc(void) { __asm volatile("svc #0\n bx lr"); }

static void stacks(void)
{
    uint32_t top = (uint32_t)(uintptr_t)(process_stack + 64);

    set_up(5, 4, 4);
    exception_priority(EXCEPTION_SVCALL, 0);
    in_a = svc_in_handler;
    pend_now(A);
    check_equal("exc-return-handler", call.exc_return, 0xFFFFFFF1);

    SCB->CCR |= CCR_STKALIGN;
    on_process_stack(plain_svc, (void *)top);
    check_equal("exc-return-thread-psp", call.exc_return, 0xFFFFFFFD);
    check_equal("frame-on-psp", call.address, top - 32);
    check_equal("frame-pc-after-svc", call.frame.pc, ((uint32_t)(uintptr_t)plain_svc & ~1u) + 2);
    check_equal("aligned-frame-has-no-mark", call.frame.xpsr & 1u << 9, 0);
    check_equal("psp-restored", READ_SPECIAL("psp"), top);

    on_process_stack(plain_svc, (void *)(top - 4));
    check_equal("stkalign-aligns-frame", call.address, top - 8 - 32);
    check_equal("aligned-frame-is-marked", call.frame.xpsr & 1u << 9, 1u << 9);
    check_equal("aligned-psp-restored", READ_SPECIAL("psp"), top - 4);

    SCB->CCR &= ~CCR_STKALIGN;
    on_process_stack(plain_svc, (void *)(top - 4));
    check_equal("no-stkalign-no-gap", call.address, top - 4 - 32);
    SCB->CCR |= CCR_STKALIGN;
}

// --- Unprivileged code cannot touch the masks (B5.2.3); SVC gives the privilege back

static volatile uint32_t primask_seen, control_seen;

static void without_privilege(void)
{
    WRITE_SPECIAL("control", 3);
    WRITE_SPECIAL("primask", 1);
    WRITE_SPECIAL("control", 2);
    control_seen = READ_SPECIAL("control");
    __asm volatile("svc %0" ::"i"(SVC_PRIVILEGE) : "memory");
    primask_seen = READ_SPECIAL("primask");
}

static void pend_unprivileged(void)
{
    WRITE_SPECIAL("control", 3);
    STIR = B;
    DSB();
    ISB();
    __asm volatile("svc %0" ::"i"(SVC_PRIVILEGE) : "memory");
}

static void privilege(void)
{
    on_process_stack(without_privilege, process_stack + 64);
    check_equal("unprivileged-cannot-mask", primask_seen, 0);
    check_equal("unprivileged-cannot-promote-itself", control_seen & 1, 1);
    check_equal("svc-gives-privilege", READ_SPECIAL("control"), 0);
    set_up(5, 4, 4);
    SCB->CCR |= CCR_USERSETMPEND;
    on_process_stack(pend_unprivileged, process_stack + 64);
    check_equal("usersetmpend-lets-stir", trace, 0x2B);
    SCB->CCR &= ~CCR_USERSETMPEND;
}

// --- The vector table in RAM

static __attribute__((aligned(256))) uint32_t ram_vectors[VECTOR_COUNT];

static void from_ram_table(void) { mark(9); }

static void vector_table_moves(void)
{
    uint32_t flash_table = SCB->VTOR;
    const uint32_t *old = (const uint32_t *)(uintptr_t)(flash_table ? flash_table : FLASH_BASE);
    for (int i = 0; i < VECTOR_COUNT; ++i)
        ram_vectors[i] = old[i];
    ram_vectors[16 + A] = (uint32_t)(uintptr_t)from_ram_table;
    SCB->VTOR = (uint32_t)(uintptr_t)ram_vectors;
    check_equal("vtor-reads-back", SCB->VTOR, (uint32_t)(uintptr_t)ram_vectors);
    DSB();
    set_up(5, 5, 5);
    pend_now(A);
    check_equal("vector-from-ram", trace, 9);
    SCB->VTOR = flash_table;
    DSB();
    set_up(5, 5, 5);
    pend_now(A);
    check_equal("vector-from-flash-again", trace, 0x1A);
}

// --- Sleep (B1.5.17, B1.5.18)

#define TICK 20000u // cycles

static void tick(uint32_t until)
{
    ticks = trace = 0;
    sleep_until_tick = until;
    SYSTICK->LOAD = TICK - 1;
    SYSTICK->VAL = 0;
    SYSTICK->CTRL = SYSTICK_CLKSOURCE | SYSTICK_TICKINT | SYSTICK_ENABLE;
}

static void sleeping(void)
{
    tick(1);
    WFI();
    check_equal("wfi-until-interrupt", ticks, 1);

    irq_disable();
    tick(1);
    WFI();
    check_equal("wfi-with-primask-takes-nothing", ticks, 0);
    check("wfi-with-primask-wakes", SCB->ICSR & ICSR_PENDSTSET);
    irq_enable();
    ISB();
    check_equal("taken-after-primask", ticks, 1);

    SCB->SCR = SCR_SLEEPONEXIT;
    tick(3);
    WFI();
    check_equal("sleep-on-exit", ticks, 3); // the handler ended it

    // WFE: an event is remembered, and the first WFE eats it
    SEV();
    WFE();
    tick(2);
    SEV();
    WFE();
    check_equal("wfe-after-sev-goes-on", ticks, 0);
    WFE();
    check("wfe-sleeps-until-interrupt", ticks >= 1);
    SYSTICK->CTRL = 0;

    // SEVONPEND: a pending interrupt wakes WFE though it is not enabled
    irq_line_disable(A);
    irq_unpend(A);
    SCB->SCR = SCR_SEVONPEND;
    SEV();
    WFE();
    irq_pend(A);
    tick(9);
    WFE();
    SYSTICK->CTRL = 0;
    check_equal("sevonpend-wakes-wfe", ticks, 0);
    SCB->SCR = 0;
    irq_unpend(A);
}

int main(void)
{
    identity();
    pending();
    order();
    masks();
    changes();
    system_calls();
    system_exceptions();
    chaining();
    stacks();
    privilege();
    vector_table_moves();
    sleeping();
    check_done();
}
