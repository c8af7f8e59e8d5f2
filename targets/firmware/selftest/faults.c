// SPDX-License-Identifier: GPL-2.0-or-later
//
// Faults: which exception, which status bits, which address, where they return to (DDI 0403, B1.5.14; PM0056, 2.4).
// Division by zero is left out: the trap for it is off in nearly all firmware.

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
    bus_faults();
    memory_faults();
    escalation();
    bad_return();
    privilege();
    check_done();
}
