// SPDX-License-Identifier: GPL-2.0-or-later
//
// Faults: which exception, which status bits, which address, where they return to (DDI 0403, B1.5.14; PM0056, 2.4).
// Division by zero is left out: the trap for it is off in nearly all firmware.

#include "check.h"
#include "chip/stm32f103.h"
#include "handlers.h"
#include "startup.h"

#define NOTHING_HERE 0x60000000u // external memory, which this chip has not (RM0008, figure 2)
#define NOT_EXECUTABLE 0x40000000u // peripherals (DDI 0403, table B3-1)

// --- Catching: a fault in `cause` ends it, and what it was is noted

static volatile struct {
    uint32_t exception, cfsr, hfsr, bfar, mmfar, pc, exc_return;
} caught;

static uint32_t sp_before_cause;

void after_cause(void);

// Calls cause(argument). If it faults, the handler comes back to after_cause, whatever the stack then looks like.
static __attribute__((naked)) void call_cause(void (*cause)(uint32_t), uint32_t argument, uint32_t *sp_kept)
{
    (void)cause;
    (void)argument;
    (void)sp_kept;
    __asm volatile("push {r2, r4-r11, lr}\n"
                   "str sp, [r2]\n"
                   "mov r3, r0\n"
                   "mov r0, r1\n"
                   "blx r3\n"
                   ".global after_cause\n"
                   ".thumb_func\n"
                   "after_cause:\n"
                   "ldr r2, =sp_before_cause\n"
                   "ldr sp, [r2]\n"
                   "pop {r2, r4-r11, pc}\n"
                   ".ltorg");
}

void fault_body(struct exception_frame *frame, uint32_t exc_return);

void fault_body(struct exception_frame *frame, uint32_t exc_return)
{
    caught.exception = READ_SPECIAL("ipsr");
    caught.cfsr = SCB->CFSR;
    caught.hfsr = SCB->HFSR;
    caught.bfar = SCB->BFAR;
    caught.mmfar = SCB->MMFAR;
    caught.pc = frame->pc;
    caught.exc_return = exc_return;
    SCB->CFSR = 0xFFFFFFFF; // write one to clear
    SCB->HFSR = 0xFFFFFFFF;
    frame->pc = (uint32_t)(uintptr_t)after_cause & ~1u;
    frame->xpsr = 1u << 24 | (frame->xpsr & 1u << 9); // thread, Thumb, no IT block; the gap stays
}

// Always returns to thread mode on the main stack, where all causes run.
static __attribute__((naked, used)) void fault(void)
{
    __asm volatile("mov r0, sp\n mov r1, lr\n push {r4, lr}\n bl fault_body\n pop {r4, lr}\n mvn lr, #6\n bx lr");
}

__attribute__((naked)) void HardFault_Handler(void) { __asm volatile("b fault"); }
__attribute__((naked)) void MemManage_Handler(void) { __asm volatile("b fault"); }
__attribute__((naked)) void BusFault_Handler(void) { __asm volatile("b fault"); }
__attribute__((naked)) void UsageFault_Handler(void) { __asm volatile("b fault"); }

static void provoke(void (*cause)(uint32_t), uint32_t argument)
{
    caught.exception = caught.cfsr = caught.hfsr = caught.pc = 0;
    call_cause(cause, argument, &sp_before_cause);
}

static uint32_t address_of(void (*cause)(uint32_t)) { return (uint32_t)(uintptr_t)cause & ~1u; }

static void expect(const char *name, uint32_t exception, uint32_t cfsr, uint32_t pc)
{
    if (caught.exception != exception)
        check_equal(name, caught.exception, exception);
    else if (caught.cfsr != cfsr)
        check_equal(name, caught.cfsr, cfsr);
    else
        check_equal(name, caught.pc, pc);
}

// --- Causes: the instruction that faults is the first

#define CAUSE(name, instruction)                                                                                        \
    static __attribute__((naked)) void name(uint32_t argument)                                                          \
    {                                                                                                                   \
        (void)argument;                                                                                                 \
        __asm volatile(instruction "\n bx lr");                                                                         \
    }

CAUSE(undefined, "udf #0")
CAUSE(undefined_wide, "udf.w #0")
CAUSE(load, "ldr r0, [r0]")
CAUSE(store, "str r0, [r0]")
CAUSE(load_halfword, "ldrh r0, [r0]")
CAUSE(load_double, "ldrd r0, r1, [r0]")
CAUSE(load_multiple, "ldmia r0, {r1, r2}")
CAUSE(jump, "bx r0")
CAUSE(coprocessor, ".inst.w 0xEE000000") // cdp p0, #0, c0, c0, c0, #0
CAUSE(system_call, "svc #0")

// --- Each fault with its own handler enabled

static void usage_faults(void)
{
    provoke(undefined, 0);
    expect("undefined-instruction", EXCEPTION_USAGEFAULT, CFSR_UNDEFINSTR, address_of(undefined));
    check_equal("fault-from-thread-link", caught.exc_return, 0xFFFFFFF9);
    provoke(undefined_wide, 0);
    expect("undefined-wide-instruction", EXCEPTION_USAGEFAULT, CFSR_UNDEFINSTR, address_of(undefined_wide));
    provoke(coprocessor, 0);
    expect("no-coprocessor", EXCEPTION_USAGEFAULT, CFSR_NOCP, address_of(coprocessor));
    provoke(jump, address_of(load)); // bit 0 clear: there is no ARM state to go to
    expect("jump-to-even-address", EXCEPTION_USAGEFAULT, CFSR_INVSTATE, address_of(load));

    static const uint32_t words[4] = {1, 2, 3, 4};
    uint32_t odd = (uint32_t)(uintptr_t)words + 1;
    provoke(load, odd);
    check_equal("unaligned-word-is-allowed", caught.exception, 0);
    provoke(load_multiple, odd); // these always fault (A3.2.1)
    expect("unaligned-ldm", EXCEPTION_USAGEFAULT, CFSR_UNALIGNED, address_of(load_multiple));
    provoke(load_double, odd);
    expect("unaligned-ldrd", EXCEPTION_USAGEFAULT, CFSR_UNALIGNED, address_of(load_double));
    SCB->CCR |= CCR_UNALIGN_TRP;
    provoke(load_halfword, odd);
    SCB->CCR &= ~CCR_UNALIGN_TRP;
    expect("unaligned-trap", EXCEPTION_USAGEFAULT, CFSR_UNALIGNED, address_of(load_halfword));
}

static void bus_faults(void)
{
    provoke(load, NOTHING_HERE + 0x10);
    expect("load-from-nowhere", EXCEPTION_BUSFAULT, CFSR_PRECISERR | CFSR_BFARVALID, address_of(load));
    check_equal("bfar-of-load", caught.bfar, NOTHING_HERE + 0x10);
    ACTLR |= ACTLR_DISDEFWBUF; // without the write buffer a store faults precisely as well (Cortex-M3 TRM, auxiliary control)
    provoke(store, NOTHING_HERE + 0x20);
    ACTLR &= ~ACTLR_DISDEFWBUF;
    expect("store-to-nowhere", EXCEPTION_BUSFAULT, CFSR_PRECISERR | CFSR_BFARVALID, address_of(store));
    check_equal("bfar-of-store", caught.bfar, NOTHING_HERE + 0x20);
    provoke(jump, NOTHING_HERE + 1);
    expect("jump-to-nowhere", EXCEPTION_BUSFAULT, CFSR_IBUSERR, NOTHING_HERE);
}

static void memory_faults(void)
{
    provoke(jump, NOT_EXECUTABLE + 1);
    expect("jump-to-peripherals", EXCEPTION_MEMMANAGE, CFSR_IACCVIOL, NOT_EXECUTABLE);
}

// --- What becomes a HardFault (B1.5.11)

static void escalation(void)
{
    SCB->SHCSR = 0;
    provoke(undefined, 0);
    expect("disabled-usage-fault-is-hardfault", EXCEPTION_HARDFAULT, CFSR_UNDEFINSTR, address_of(undefined));
    check_equal("hfsr-forced", caught.hfsr, HFSR_FORCED);
    provoke(load, NOTHING_HERE);
    expect("disabled-bus-fault-is-hardfault", EXCEPTION_HARDFAULT, CFSR_PRECISERR | CFSR_BFARVALID, address_of(load));
    SCB->SHCSR = SHCSR_MEMFAULTENA | SHCSR_BUSFAULTENA | SHCSR_USGFAULTENA;

    irq_disable();
    provoke(undefined, 0);
    expect("masked-usage-fault-is-hardfault", EXCEPTION_HARDFAULT, CFSR_UNDEFINSTR, address_of(undefined));
    provoke(system_call, 0);
    expect("masked-svc-is-hardfault", EXCEPTION_HARDFAULT, 0, address_of(system_call) + 2);
    check_equal("masked-svc-forced", caught.hfsr, HFSR_FORCED);
    irq_enable();

    exception_priority(EXCEPTION_USAGEFAULT, 5);
    WRITE_SPECIAL("basepri", 5 << 4);
    provoke(undefined, 0);
    expect("usage-fault-below-basepri-is-hardfault", EXCEPTION_HARDFAULT, CFSR_UNDEFINSTR, address_of(undefined));
    WRITE_SPECIAL("basepri", 0);
    exception_priority(EXCEPTION_USAGEFAULT, 0);
}

// --- Unprivileged code may not touch the system control space (B3.2)

// Gives privilege.
void SVC_Handler(void) { WRITE_SPECIAL("control", 0); }

static __attribute__((naked)) void unprivileged_load(uint32_t address)
{
    (void)address;
    __asm volatile("mov r1, #1\n msr control, r1\n isb\n ldr r0, [r0]\n bx lr");
}

static void privilege(void)
{
    provoke(unprivileged_load, (uint32_t)(uintptr_t)&SCB->CPUID);
    system_call(0); // the fault came back to unprivileged thread code, and there is no printing for that
    check_equal("svc-regains-privilege", READ_SPECIAL("control"), 0);
    check_equal("unprivileged-scs-is-bus-fault", caught.exception, EXCEPTION_BUSFAULT);
    check_equal("unprivileged-scs-precise", caught.cfsr, CFSR_PRECISERR | CFSR_BFARVALID);
    check_equal("unprivileged-scs-address", caught.bfar, (uint32_t)(uintptr_t)&SCB->CPUID);
}

// --- A return to nowhere: a reserved EXC_RETURN faults at the place where the handler came from (B1.5.8)

__attribute__((naked)) void PendSV_Handler(void)
{
    __asm volatile("mvn lr, #12\n bx lr"); // 0xFFFFFFF3
}

static void pend_bad_return(uint32_t unused)
{
    (void)unused;
    SCB->ICSR = ICSR_PENDSVSET;
    DSB();
    ISB();
}

static void bad_return(void)
{
    provoke(pend_bad_return, 0);
    check_equal("reserved-exc-return", caught.exception, EXCEPTION_USAGEFAULT);
    check_equal("reserved-exc-return-invpc", caught.cfsr, CFSR_INVPC);
}

int main(void)
{
    check_equal("faults-are-disabled-after-reset", SCB->SHCSR, 0);
    SCB->SHCSR = SHCSR_MEMFAULTENA | SHCSR_BUSFAULTENA | SHCSR_USGFAULTENA;
    SCB->CCR |= CCR_STKALIGN;
    usage_faults();
    bus_faults();
    memory_faults();
    escalation();
    bad_return();
    privilege();
    check_done();
}
