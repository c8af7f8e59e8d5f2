// SPDX-License-Identifier: GPL-2.0-or-later
//
// Faults: which exception, which status bits, which address, where they return to (DDI 0403, B1.5.14; PM0056, 2.4).
// Unaligned accesses of several words are in unaligned.c.

#include "catch.h"
#include "check.h"
#include "chip/stm32f103.h"
#include "handlers.h"

#define NOTHING_HERE 0x60000000u // external memory, which this chip has not (RM0008, figure 2)
#define NOT_EXECUTABLE 0x40000000u // peripherals (DDI 0403, table B3-1)

// --- Causes

CAUSE(undefined, "udf #0")
CAUSE(undefined_wide, "udf.w #0")
CAUSE(load, "ldr r0, [r0]")
CAUSE(store, "str r0, [r0]")
CAUSE(jump, "bx r0")
CAUSE(coprocessor, ".inst.w 0xEE000000") // cdp p0, #0, c0, c0, c0, #0
CAUSE(system_call, "svc #0")
CAUSE(load_halfword, "ldrh r0, [r0]")
CAUSE(store_halfword, "strh r0, [r0]")
CAUSE(divide, "sdiv r0, r0, r0")
CAUSE(divide_unsigned, "udiv r1, r1, r0")
CAUSE(divide_unless_zero, "cmp r0, #0\n ite ne\n sdivne r0, r0, r0\n moveq r0, #1")

// --- Each fault with its own handler enabled

static void usage_faults(void)
{
    provoke(undefined, 0);
    expect_caught("undefined-instruction", EXCEPTION_USAGEFAULT, CFSR_UNDEFINSTR, address_of(undefined));
    check_equal("fault-from-thread-link", caught.exc_return, 0xFFFFFFF9);
    provoke(undefined_wide, 0);
    expect_caught("undefined-wide-instruction", EXCEPTION_USAGEFAULT, CFSR_UNDEFINSTR, address_of(undefined_wide));
    provoke(coprocessor, 0);
    expect_caught("no-coprocessor", EXCEPTION_USAGEFAULT, CFSR_NOCP, address_of(coprocessor));
    provoke(jump, address_of(load)); // bit 0 clear: there is no ARM state to go to
    expect_caught("jump-to-even-address", EXCEPTION_USAGEFAULT, CFSR_INVSTATE, address_of(load));
}

// Without the traps, single accesses may be unaligned (A3.2.1), and a division by zero gives zero (A7.7.127).
static void traps(void)
{
    static uint32_t words[2];
    uint32_t odd = (uint32_t)(uintptr_t)words + 1;
    provoke(load, odd);
    provoke(store_halfword, odd);
    provoke(divide, 0);
    check_equal("no-trap-unless-asked-for", caught.exception, 0);
    SCB->CCR |= CCR_UNALIGN_TRP;
    provoke(load, odd);
    expect_caught("unaligned-word-traps", EXCEPTION_USAGEFAULT, CFSR_UNALIGNED, address_of(load));
    provoke(load_halfword, odd);
    expect_caught("unaligned-half-word-traps", EXCEPTION_USAGEFAULT, CFSR_UNALIGNED, address_of(load_halfword));
    provoke(store_halfword, odd);
    expect_caught("unaligned-store-traps", EXCEPTION_USAGEFAULT, CFSR_UNALIGNED, address_of(store_halfword));
    provoke(load_halfword, odd + 1);
    check_equal("aligned-half-word-does-not", caught.exception, 0);
    SCB->CCR = (SCB->CCR & ~CCR_UNALIGN_TRP) | CCR_DIV_0_TRP;
    provoke(divide, 0);
    expect_caught("division-by-zero-traps", EXCEPTION_USAGEFAULT, CFSR_DIVBYZERO, address_of(divide));
    provoke(divide_unsigned, 0);
    expect_caught("unsigned-division-traps", EXCEPTION_USAGEFAULT, CFSR_DIVBYZERO, address_of(divide_unsigned));
    provoke(divide_unless_zero, 0);
    check_equal("skipped-division-does-not", caught.exception, 0);
    provoke(divide, 7);
    check_equal("division-by-seven-does-not", caught.exception, 0);
    SCB->CCR &= ~CCR_DIV_0_TRP;
    provoke(divide, 0);
    check_equal("no-trap-any-more", caught.exception, 0);
}

static void bus_faults(void)
{
    provoke(load, NOTHING_HERE + 0x10);
    expect_caught("load-from-nowhere", EXCEPTION_BUSFAULT, CFSR_PRECISERR | CFSR_BFARVALID, address_of(load));
    check_equal("bfar-of-load", caught.bfar, NOTHING_HERE + 0x10);
    ACTLR |= ACTLR_DISDEFWBUF; // without the write buffer a store faults precisely as well (Cortex-M3 TRM, auxiliary control)
    provoke(store, NOTHING_HERE + 0x20);
    ACTLR &= ~ACTLR_DISDEFWBUF;
    expect_caught("store-to-nowhere", EXCEPTION_BUSFAULT, CFSR_PRECISERR | CFSR_BFARVALID, address_of(store));
    check_equal("bfar-of-store", caught.bfar, NOTHING_HERE + 0x20);
    provoke(jump, NOTHING_HERE + 1);
    expect_caught("jump-to-nowhere", EXCEPTION_BUSFAULT, CFSR_IBUSERR, NOTHING_HERE);
}

static void memory_faults(void)
{
    provoke(jump, NOT_EXECUTABLE + 1);
    expect_caught("jump-to-peripherals", EXCEPTION_MEMMANAGE, CFSR_IACCVIOL, NOT_EXECUTABLE);
}

// --- What becomes a HardFault (B1.5.11)

static void escalation(void)
{
    SCB->SHCSR = 0;
    provoke(undefined, 0);
    expect_caught("disabled-usage-fault-is-hardfault", EXCEPTION_HARDFAULT, CFSR_UNDEFINSTR, address_of(undefined));
    check_equal("hfsr-forced", caught.hfsr, HFSR_FORCED);
    provoke(load, NOTHING_HERE);
    expect_caught("disabled-bus-fault-is-hardfault", EXCEPTION_HARDFAULT, CFSR_PRECISERR | CFSR_BFARVALID, address_of(load));
    SCB->SHCSR = SHCSR_MEMFAULTENA | SHCSR_BUSFAULTENA | SHCSR_USGFAULTENA;

    irq_disable();
    provoke(undefined, 0);
    expect_caught("masked-usage-fault-is-hardfault", EXCEPTION_HARDFAULT, CFSR_UNDEFINSTR, address_of(undefined));
    provoke(system_call, 0);
    check_equal("masked-svc-is-hardfault", caught.exception, EXCEPTION_HARDFAULT);
    check_equal("masked-svc-forced", caught.hfsr, HFSR_FORCED);
    check_equal("masked-svc-returns-behind-it", caught.pc, address_of(system_call) + 2); // B1.5.4, B1.5.6
    irq_enable();

    exception_priority(EXCEPTION_USAGEFAULT, 5);
    WRITE_SPECIAL("basepri", 5 << 4);
    provoke(undefined, 0);
    expect_caught("usage-fault-below-basepri-is-hardfault", EXCEPTION_HARDFAULT, CFSR_UNDEFINSTR, address_of(undefined));
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
    traps();
    bus_faults();
    memory_faults();
    escalation();
    bad_return();
    privilege();
    check_done();
}
