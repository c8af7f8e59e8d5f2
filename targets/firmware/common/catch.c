// SPDX-License-Identifier: GPL-2.0-or-later

#include "catch.h"

#include "check.h"
#include "chip/stm32f103.h"
#include "handlers.h"
#include "startup.h"

volatile struct caught caught;

uint32_t catch_sp; // before the cause

void after_cause(void);

// If the cause faults, the handler comes back to after_cause, whatever the stack then looks like.
static __attribute__((naked)) void call_cause(void (*cause)(uint32_t), uint32_t argument)
{
    (void)cause;
    (void)argument;
    __asm volatile("push {r3-r11, lr}\n"
                   "ldr r2, =catch_sp\n"
                   "str sp, [r2]\n"
                   "mov r3, r0\n"
                   "mov r0, r1\n"
                   "blx r3\n"
                   ".global after_cause\n"
                   ".thumb_func\n"
                   "after_cause:\n"
                   "ldr r2, =catch_sp\n"
                   "ldr sp, [r2]\n"
                   "pop {r3-r11, pc}\n"
                   ".ltorg");
}

void catch_fault(struct exception_frame *frame, uint32_t exc_return);

void catch_fault(struct exception_frame *frame, uint32_t exc_return)
{
    caught.exception = READ_SPECIAL("ipsr");
    caught.cfsr = SCB->CFSR;
    caught.hfsr = SCB->HFSR;
    caught.bfar = SCB->BFAR;
    caught.pc = frame->pc;
    caught.exc_return = exc_return;
    SCB->CFSR = 0xFFFFFFFF; // write one to clear
    SCB->HFSR = 0xFFFFFFFF;
    frame->pc = (uint32_t)(uintptr_t)after_cause & ~1u;
    frame->xpsr = 1u << 24 | (frame->xpsr & 1u << 9); // thread, Thumb, no IT block; the gap stays
}

// Always returns to thread mode on the main stack, where all causes run.
#define CATCH __asm volatile("mov r0, sp\n mov r1, lr\n push {r4, lr}\n bl catch_fault\n pop {r4, lr}\n mvn lr, #6\n bx lr")

__attribute__((naked)) void HardFault_Handler(void) { CATCH; }
__attribute__((naked)) void MemManage_Handler(void) { CATCH; }
__attribute__((naked)) void BusFault_Handler(void) { CATCH; }
__attribute__((naked)) void UsageFault_Handler(void) { CATCH; }

void provoke(void (*cause)(uint32_t), uint32_t argument)
{
    caught = (struct caught){0};
    call_cause(cause, argument);
}

void expect_caught(const char *name, uint32_t exception, uint32_t cfsr, uint32_t pc)
{
    if (caught.exception != exception)
        check_equal(name, caught.exception, exception);
    else if (caught.cfsr != cfsr)
        check_equal(name, caught.cfsr, cfsr);
    else
        check_equal(name, caught.pc, pc);
}
