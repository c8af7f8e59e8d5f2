"""Faults: their bits, escalation, faults within entry and return, lockup."""

from __future__ import annotations

import pytest

from targets.mcu.cortexm.exceptions import Number
from targets.mcu.engine.api import FaultKind, Reg, StopKind

HARD, MEM, BUS, USAGE = Number.HARD_FAULT, Number.MEM_MANAGE, Number.BUS_FAULT, Number.USAGE_FAULT
NOWHERE = 0x3000_0000
FORCED, VECTTBL, DEBUGEVT = 1 << 30, 1 << 1, 1 << 31
ENABLE_ALL = 0x0007_0000


def put_code(rig, *halves):
    for index, half in enumerate(halves):
        rig.memory.write(rig.MAIN + 2 * index, 2, half)


def stacked_pc(rig):
    return rig.memory.read(rig.cpu.get(Reg.SP) + 24, 4)


CAUSES = [
    (FaultKind.READ, NOWHERE, (), BUS, 0x8200),
    (FaultKind.WRITE, NOWHERE, (), BUS, 0x8200),
    (FaultKind.FETCH, NOWHERE, (), BUS, 0x0100),
    (FaultKind.FETCH, 0x4000_0000, (), MEM, 0x0001),
    (FaultKind.FETCH, 0xFFFF_FFFE, (), MEM, 0x0001),
    (FaultKind.UNDEFINED, 0, (0xDE00,), USAGE, 0x1_0000),
    (FaultKind.UNDEFINED, 0, (0xEE30, 0x0A00), USAGE, 0x8_0000),  # vadd.f32
    (FaultKind.UNDEFINED, 0, (0xFC00, 0x0000), USAGE, 0x8_0000),
    (FaultKind.UNDEFINED, 0, (0xEF00, 0x0000), USAGE, 0x1_0000),  # where Advanced SIMD would be
    (FaultKind.STATE, 0, (), USAGE, 0x2_0000),
    (FaultKind.UNALIGNED, 0x2000_0001, (), USAGE, 0x100_0000),
    (FaultKind.DIVISION, 0, (), USAGE, 0x200_0000),
]


def test_the_program_chooses_what_traps(rig):
    for value, traps in ((0x10, (True, False)), (0x18, (True, True)), (0x208, (False, True))):
        rig.poke("SCB", "CCR", value)
        assert rig.cpu.traps == traps
        assert rig.peek("SCB", "CCR") == value
    rig.core.reset(rig.VECTORS)
    assert rig.cpu.traps == (False, False)


class TestCauses:
    @pytest.mark.parametrize(("kind", "address", "code", "exception", "cfsr"), CAUSES)
    def test_with_its_own_handler(self, rig, kind, address, code, exception, cfsr):
        self.arrange(rig, kind, address, code)
        rig.poke("SCB", "SHCSR", ENABLE_ALL)
        pc = rig.cpu.get(Reg.PC)
        rig.fault(kind, address)
        assert rig.taken == [(exception, 12)]
        assert rig.peek("SCB", "CFSR") == cfsr
        assert rig.peek("SCB", "HFSR") == 0
        assert stacked_pc(rig) == pc
        fault = rig.core.last_fault
        assert (fault.exception, fault.origin, fault.escalated) == (exception, exception, False)
        assert fault.pc == pc

    @pytest.mark.parametrize(("kind", "address", "code", "exception", "cfsr"), CAUSES)
    def test_disabled_it_is_a_hard_fault(self, rig, kind, address, code, exception, cfsr):
        self.arrange(rig, kind, address, code)
        rig.fault(kind, address)
        assert rig.began == [HARD]
        assert rig.peek("SCB", "CFSR") == cfsr
        assert rig.peek("SCB", "HFSR") == FORCED
        fault = rig.core.last_fault
        assert (fault.exception, fault.origin, fault.escalated) == (HARD, exception, True)
        assert "escalated to HardFault" in fault.describe()

    def arrange(self, rig, kind, address, code):
        put_code(rig, *code)
        if kind is FaultKind.FETCH:
            rig.cpu.set(Reg.PC, address)

    def test_bus_fault_address(self, rig):
        rig.fault(FaultKind.READ, 0x3000_1234)
        assert rig.peek("SCB", "BFAR") == 0x3000_1234
        assert rig.core.last_fault.address == 0x3000_1234
        assert rig.core.last_fault.causes == ("PRECISERR",)
        rig.poke("SCB", "CFSR", 0x8000)
        assert rig.peek("SCB", "CFSR") == 0x0200

    def test_status_bits_are_cleared_by_ones_in_their_own_bytes(self, rig):
        rig.fault(FaultKind.READ, NOWHERE)
        rig.core.scb.record_fault(0x1_0001, 0, None)
        cfsr = rig.address("SCB", "CFSR")
        assert rig.read(cfsr + 1, 1) == 0x82
        assert rig.read(cfsr + 2, 2) == 0x0001
        rig.write(cfsr + 1, 0xFF, 1)
        assert rig.peek("SCB", "CFSR") == 0x1_0001
        rig.write(cfsr + 2, 0xFFFF, 2)
        assert rig.peek("SCB", "CFSR") == 0x0_0001
        rig.poke("SCB", "HFSR", FORCED)
        assert rig.peek("SCB", "HFSR") == 0

    def test_a_store_that_fails_is_said_to_be_precise_by_choice(self, rig):
        rig.fault(FaultKind.WRITE, NOWHERE)
        assert rig.chip.noted("assumed") == ["SCB_CFSR.PRECISERR"]

    def test_callback_and_text(self, rig):
        seen = []
        rig.core.on_fault = seen.append
        rig.fault(FaultKind.READ, NOWHERE)
        assert seen == [rig.core.last_fault]
        text = seen[0].describe()
        assert "BusFault" in text
        assert "Thread mode at 0x08000400" in text
        assert "0x30000000" in text


ESCALATION = [
    # priority of the fault, priority of what runs, mask register, its value: does the own handler run?
    (0x20, None, None, 0, True),
    (0x20, 0x40, None, 0, True),
    (0x20, 0x20, None, 0, False),
    (0x40, 0x20, None, 0, False),
    (0x20, None, Reg.PRIMASK, 1, False),
    (0x20, None, Reg.BASEPRI, 0x20, False),
    (0x20, None, Reg.BASEPRI, 0x30, True),
]


class TestEscalation:
    @pytest.mark.parametrize(("own", "running", "mask", "value", "handled"), ESCALATION)
    @pytest.mark.parametrize("exception", [BUS, USAGE, Number.SVCALL, Number.DEBUG_MONITOR])
    def test_by_priority(self, rig, own, running, mask, value, handled, exception):
        rig.poke("SCB", "SHCSR", ENABLE_ALL)
        rig.poke("SCB", "DEMCR", 1 << 16)
        rig.core.exceptions.set_priority(exception, own)
        if running is not None:
            rig.interrupt(0, priority=running)
            rig.settle()
        if mask is not None:
            rig.cpu.set(mask, value)
        if exception == Number.SVCALL:
            rig.svc()
        elif exception == Number.DEBUG_MONITOR:
            rig.stop(StopKind.BREAKPOINT, 1)
        else:
            rig.fault(FaultKind.READ if exception == BUS else FaultKind.UNDEFINED, NOWHERE)
        assert rig.core.running == (exception if handled else HARD)
        expected = DEBUGEVT if exception == Number.DEBUG_MONITOR else FORCED
        assert rig.peek("SCB", "HFSR") == (0 if handled else expected)

    def test_group_priority_decides(self, rig):
        rig.poke("SCB", "SHCSR", ENABLE_ALL)
        rig.poke("SCB", "AIRCR", 0x05FA_0500)
        rig.core.exceptions.set_priority(BUS, 0x00)
        rig.interrupt(0, priority=0x30)  # the same group
        rig.settle()
        rig.fault(FaultKind.READ, NOWHERE)
        assert rig.core.running == HARD

    def test_a_fault_in_its_own_handler(self, rig):
        rig.poke("SCB", "SHCSR", ENABLE_ALL)
        rig.fault(FaultKind.READ, NOWHERE)
        rig.fault(FaultKind.READ, NOWHERE)
        assert rig.began == [BUS, HARD]

    @pytest.mark.parametrize(("mask", "value"), [(Reg.PRIMASK, 1), (Reg.BASEPRI, 0x20)])
    def test_an_escalated_supervisor_call_returns_behind_itself(self, rig, mask, value):
        """As SVCall would: the kernels that mask interrupts and call find the instruction before the stacked PC."""
        pc = rig.cpu.get(Reg.PC)
        rig.core.exceptions.set_priority(Number.SVCALL, 0x20)
        rig.cpu.set(mask, value)
        rig.svc()
        assert rig.began == [HARD]
        assert stacked_pc(rig) == pc + 2
        fault = rig.core.last_fault
        assert (fault.causes, fault.pc) == (("SVC",), pc)
        assert "supervisor call" in fault.describe()

    def test_a_breakpoint_without_debugger(self, rig):
        pc = rig.cpu.get(Reg.PC)
        rig.stop(StopKind.BREAKPOINT, 0)
        assert rig.began == [HARD]
        assert rig.peek("SCB", "HFSR") == DEBUGEVT
        assert rig.peek("SCB", "DFSR") == 2
        assert stacked_pc(rig) == pc

    def test_a_more_urgent_interrupt_goes_before_the_fault(self, rig):
        rig.poke("SCB", "SHCSR", ENABLE_ALL)
        rig.core.exceptions.set_priority(BUS, 0x40)
        rig.core.exceptions.set_priority(16, 0x20)
        rig.core.exceptions.enable(16)
        rig.chip.time.at(5, lambda: rig.core.exceptions.pend(16))
        rig.fault(FaultKind.READ, NOWHERE)
        assert rig.began == [16]
        rig.exit()
        assert rig.began == [16, BUS]


class TestWithinEntry:
    def test_stack_that_cannot_be_written(self, rig):
        """The interrupt stays pending, HardFault arrives late in its place, the pointer has moved."""
        rig.cpu.set(Reg.MSP, rig.RAM + 16)
        rig.interrupt(0)
        rig.settle()
        assert rig.taken == [(HARD, 12)]
        assert rig.peek("SCB", "CFSR") == 0x1000
        assert rig.peek("SCB", "HFSR") == FORCED
        assert rig.core.exceptions.is_pending(16)
        assert rig.cpu.get(Reg.MSP) == rig.RAM - 16

    def test_bus_fault_that_is_less_urgent_waits(self, rig):
        rig.poke("SCB", "SHCSR", ENABLE_ALL)
        rig.core.exceptions.set_priority(BUS, 0x80)
        rig.cpu.set(Reg.MSP, rig.RAM + 16)
        rig.interrupt(0, priority=0x40)
        rig.settle()
        assert rig.began == [16]
        assert rig.core.exceptions.is_pending(BUS)

    def test_bus_fault_that_is_more_urgent_goes_first(self, rig):
        rig.poke("SCB", "SHCSR", ENABLE_ALL)
        rig.core.exceptions.set_priority(BUS, 0x20)
        rig.cpu.set(Reg.PSP, rig.RAM + 16)
        rig.cpu.set(Reg.CONTROL, 2)
        rig.interrupt(0, priority=0x40)
        rig.settle()
        assert rig.began == [BUS]
        assert rig.cpu.get(Reg.LR) == 0xFFFF_FFFD

    def test_vector_that_cannot_be_read(self, rig):
        rig.poke("SCB", "VTOR", rig.RAM + 0x300)  # the table reaches beyond RAM from interrupt 48 on
        rig.memory.write(rig.RAM + 0x300 + 12, 4, 0x0800_0F01)
        rig.core.exceptions.set_priority(58, 0x40)
        for address in range(rig.RAM + 0x300 + 4 * 58, rig.RAM + 0x400):
            del rig.memory.memory[address]
        rig.cpu.set(Reg.MSP, rig.RAM + 0x200)
        rig.core.exceptions.enable(58)
        rig.core.exceptions.pend(58)
        rig.settle()
        assert rig.taken == [(HARD, 12)]
        assert rig.peek("SCB", "HFSR") == VECTTBL
        assert rig.core.exceptions.is_pending(58)

    def test_even_vector(self, rig):
        rig.memory.write(rig.VECTORS + 4 * 16, 4, 0x0800_0F00)
        rig.interrupt(0)
        rig.settle()
        assert rig.began[-1] == HARD
        assert rig.peek("SCB", "CFSR") == 0x2_0000
        assert stacked_pc(rig) == 0x0800_0F00
        assert rig.memory.read(rig.cpu.get(Reg.SP) + 28, 4) == 16  # T is clear
        assert rig.core.exceptions.is_active(16)

    def test_erased_vector(self, rig):
        rig.memory.write(rig.VECTORS + 4 * 16, 4, 0xFFFF_FFFF)
        rig.interrupt(0)
        rig.settle()
        assert rig.core.running == HARD
        assert rig.peek("SCB", "CFSR") == 0x1
        assert stacked_pc(rig) == 0xFFFF_FFFE


class TestWithinReturn:
    @pytest.fixture
    def inside(self, rig):
        rig.interrupt(0, priority=0x40)
        rig.settle()
        rig.taken.clear()
        return rig

    @pytest.mark.parametrize("value", [0xFFFF_FFF0, 0xFFFF_FFFF, 0xFFFF_FFE9, 0xFFFF_FFF1, 0xF000_0009])
    def test_wrong_values(self, inside, value):
        sp = inside.cpu.get(Reg.MSP)
        inside.exit(value)
        assert inside.began == [HARD]
        assert inside.peek("SCB", "CFSR") == 0x4_0000
        assert inside.cpu.get(Reg.MSP) == sp
        assert inside.cpu.get(Reg.LR) == value
        assert not inside.core.exceptions.is_active(16)

    def test_usage_fault_takes_it_if_enabled(self, inside):
        inside.poke("SCB", "SHCSR", ENABLE_ALL)
        inside.exit(0xFFFF_FFF0)
        assert inside.began == [USAGE]

    def test_to_thread_from_a_nested_handler(self, inside):
        inside.interrupt(1, priority=0x20)
        inside.settle()
        inside.exit(0xFFFF_FFF9)
        assert inside.core.last_fault.causes == ("INVPC",)

    def test_to_thread_from_a_nested_handler_if_allowed(self, inside):
        inside.poke("SCB", "CCR", 1)
        inside.interrupt(1, priority=0x20)
        inside.settle()
        sp = inside.cpu.get(Reg.MSP)
        inside.memory.write(sp + 28, 4, 0x0100_0000)
        inside.exit(0xFFFF_FFF9)
        assert inside.core.last_fault is None
        assert inside.core.running == 0
        assert inside.core.exceptions.is_active(16)

    def test_a_handler_that_is_not_active(self, inside):
        inside.core.exceptions.set_active(16, False)
        inside.exit()
        assert inside.began == [HARD]
        assert inside.peek("SCB", "CFSR") == 0x4_0000

    @pytest.mark.parametrize("nested", [False, True])
    def test_wrong_exception_number_on_the_stack(self, inside, nested):
        if nested:
            inside.interrupt(1, priority=0x20)
            inside.settle()
            inside.taken.clear()
        sp = inside.cpu.get(Reg.MSP)
        inside.memory.write(sp + 28, 4, 0x0100_0000 | (0 if nested else 17))
        inside.exit()
        assert inside.began == [HARD]
        assert inside.core.last_fault.causes == ("INVPC",)
        assert inside.cpu.get(Reg.MSP) == sp

    def test_stack_that_cannot_be_read(self, inside):
        inside.cpu.set(Reg.MSP, NOWHERE)
        for address in range(NOWHERE - 32, NOWHERE):
            inside.memory.memory[address] = 0
        inside.exit()
        assert inside.core.last_fault.causes == ("UNSTKERR",)
        assert inside.began == [HARD]

    def test_to_arm_state(self, inside):
        sp = inside.cpu.get(Reg.MSP)
        inside.memory.write(sp + 28, 4, 0x6000_0000)
        inside.exit()
        assert inside.core.last_fault.causes == ("INVSTATE",)
        assert inside.core.running == HARD
        assert inside.memory.read(inside.cpu.get(Reg.MSP) + 28, 4) == 0x6000_0000


class TestLockup:
    def test_fault_in_hard_fault(self, rig):
        rig.fault(FaultKind.READ, NOWHERE)
        cycle = rig.cpu.cycle
        rig.fault(FaultKind.UNDEFINED)
        lockup = rig.core.locked_up
        assert lockup is not None
        assert [fault.origin for fault in lockup.faults] == [BUS, USAGE]
        assert lockup.faults[-1].exception == 0
        assert lockup.pc == rig.handler(HARD)
        assert lockup.cycle == cycle
        assert "HardFault" in lockup.cause
        assert not rig.core.can_take()
        assert not rig.core.take()

    @pytest.mark.parametrize("what", ["svc", "bkpt", "fault"])
    @pytest.mark.parametrize("where", ["nmi", "faultmask"])
    def test_at_the_priority_of_hard_fault_or_above(self, rig, what, where):
        if where == "nmi":
            rig.poke("SCB", "ICSR", 1 << 31)
            rig.settle()
        else:
            rig.cpu.set(Reg.FAULTMASK, 1)
        pc = rig.cpu.get(Reg.PC)
        if what == "svc":
            rig.svc()
        elif what == "bkpt":
            rig.stop(StopKind.BREAKPOINT)
        else:
            rig.fault(FaultKind.STATE)
        assert rig.core.locked_up.pc == rig.cpu.get(Reg.PC) == pc

    def test_hard_fault_without_stack_locks_up_at_its_first_push(self, rig):
        rig.cpu.set(Reg.MSP, rig.RAM)
        rig.fault(FaultKind.READ, NOWHERE)
        assert rig.core.running == HARD
        rig.fault(FaultKind.WRITE, rig.RAM - 40)
        assert [fault.causes for fault in rig.core.locked_up.faults] == [("STKERR",), ("PRECISERR",)]

    def test_hard_fault_without_vector(self, rig):
        rig.poke("SCB", "VTOR", 0x3000_0000)
        rig.fault(FaultKind.UNDEFINED)
        assert rig.core.locked_up is not None
        assert "vector table" in rig.core.locked_up.cause

    def test_reset_vector_that_cannot_be_read(self, rig):
        rig.core.reset(0x3000_0000)
        assert rig.core.locked_up is not None

    def test_even_reset_vector_is_a_hard_fault(self, rig):
        rig.memory.write(rig.VECTORS + 4, 4, rig.MAIN)
        rig.core.reset(rig.VECTORS)
        rig.settle()
        assert rig.core.running == HARD
        assert rig.core.last_fault.causes == ("INVSTATE",)
        assert stacked_pc(rig) == rig.MAIN

    def test_erased_vector_table(self, rig):
        for address in range(0, 0x100, 4):
            rig.memory.write(rig.VECTORS + address, 4, 0xFFFF_FFFF)
        rig.core.reset(rig.VECTORS)
        rig.settle()
        assert rig.core.locked_up is not None
        assert "IACCVIOL" in {cause for fault in rig.core.locked_up.faults for cause in fault.causes}

    def test_reset_ends_it(self, rig):
        rig.cpu.set(Reg.FAULTMASK, 1)
        rig.fault(FaultKind.STATE)
        rig.core.reset(rig.VECTORS)
        assert rig.core.locked_up is None
        rig.interrupt(0)
        rig.settle()
        assert rig.core.running == 16

    def test_faults_that_were_returned_from_are_not_told(self, rig):
        rig.fault(FaultKind.READ, NOWHERE)
        rig.exit()
        rig.cpu.set(Reg.FAULTMASK, 1)
        rig.fault(FaultKind.STATE)
        assert [fault.origin for fault in rig.core.locked_up.faults] == [USAGE]


class TestIgnoredBusFaults:
    @pytest.mark.parametrize(("code", "length"), [((0x6800,), 2), ((0xF8D0, 0x1000), 4)])
    def test_hard_fault_passes_over_them(self, rig, code, length):
        rig.poke("SCB", "CCR", 0x100)
        rig.fault(FaultKind.UNDEFINED)
        rig.cpu.set(Reg.PC, rig.MAIN)
        put_code(rig, *code)
        rig.fault(FaultKind.READ, NOWHERE)
        assert rig.core.locked_up is None
        assert rig.cpu.get(Reg.PC) == rig.MAIN + length
        assert rig.peek("SCB", "CFSR") == 0x1_8200
        assert rig.peek("SCB", "BFAR") == NOWHERE

    def test_nobody_else_does(self, rig):
        rig.poke("SCB", "CCR", 0x100)
        rig.fault(FaultKind.READ, NOWHERE)
        assert rig.began == [HARD]
