"""Floating-point contexts at exception entry and return: frames, EXC_RETURN, lazy stacking."""

from __future__ import annotations

import pytest

from targets.mcu.cortexm.exceptions import Number
from targets.mcu.cortexm.kinds import CORTEX_M3
from targets.mcu.engine.api import FaultKind, FloatAccess, Reg
from tests.each import each

FPCA, SPSEL, NPRIV = 4, 2, 1
ASPEN, LSPEN, LSPACT, USER, THREAD, HFRDY, MMRDY, BFRDY, MONRDY = (1 << bit for bit in (31, 30, 0, 1, 3, 4, 5, 6, 8))
SINGLES = [0x0101_0101 * (n + 1) for n in range(16)]
FPSCR = 0x6000_0011
EXTENDED, BASIC = 104, 32
ENTRY_CYCLES, TAIL_CHAIN_CYCLES, RETURN_CYCLES, FLOAT_CYCLES = 12, 6, 12, 9
NOCP = 1 << 19


@pytest.fixture(name="rig")
def rig_with_floats(m7):
    """A Cortex-M7 whose program has allowed floating point."""
    m7.poke("SCB", "CPACR", 0xF << 20)
    return m7


def begin_context(rig, singles=SINGLES, fpscr=FPSCR):
    rig.cpu.use_floats(*singles)
    rig.cpu.put_float(32, fpscr)


def words(rig, address, count):
    return [rig.memory.read(address + 4 * index, 4) for index in range(count)]


def enter(rig, irq=0, priority=0x80):
    rig.interrupt(irq, priority=priority)
    rig.settle()
    return rig.cpu.get(Reg.MSP)


class TestFrame:
    def test_without_a_context_it_is_as_ever(self, rig):
        assert enter(rig) == rig.STACK_TOP - BASIC
        assert rig.cpu.get(Reg.LR) == 0xFFFF_FFF9
        assert rig.peek("FPU", "FPCCR") == ASPEN | LSPEN

    def test_registers_lie_behind_xpsr(self, rig):
        begin_context(rig)
        rig.cpu.set(Reg.R0, 0xAAAA)
        sp = enter(rig)
        assert sp == rig.STACK_TOP - EXTENDED
        assert words(rig, sp, 1) == [0xAAAA]
        assert words(rig, sp + 24, 2) == [rig.MAIN, 1 << 24]
        assert words(rig, sp + 32, 17) == [*SINGLES, FPSCR]

    def test_the_last_word_is_not_written(self, rig):
        begin_context(rig)
        rig.memory.write(rig.STACK_TOP - 4, 4, 0x1234_5678)
        enter(rig)
        assert words(rig, rig.STACK_TOP - 4, 1) == [0x1234_5678]

    @pytest.mark.parametrize("offset", [0, 4])
    def test_it_is_always_aligned(self, rig, offset):
        begin_context(rig)
        rig.cpu.set(Reg.MSP, rig.STACK_TOP - 16 - offset)
        sp = enter(rig)
        assert sp == rig.STACK_TOP - 16 - 2 * offset - EXTENDED
        assert words(rig, sp + 28, 1) == [1 << 24 | (1 << 9 if offset else 0)]
        rig.exit()
        assert rig.cpu.get(Reg.MSP) == rig.STACK_TOP - 16 - offset

    @pytest.mark.parametrize(
        ("control", "exc_return"), [(0, 0xFFFF_FFE9), (SPSEL, 0xFFFF_FFED), (SPSEL | NPRIV, 0xFFFF_FFED)]
    )
    def test_exc_return_of_thread_mode(self, rig, control, exc_return):
        rig.cpu.set(Reg.PSP, rig.RAM + 0x200)
        rig.cpu.set(Reg.CONTROL, control)
        begin_context(rig)
        enter(rig)
        assert rig.cpu.get(Reg.LR) == exc_return
        assert rig.cpu.get(Reg.PSP) == rig.RAM + 0x200 - (EXTENDED if control & SPSEL else 0)
        assert rig.cpu.get(Reg.CONTROL) == control & NPRIV
        rig.exit()
        assert rig.cpu.get(Reg.CONTROL) == control | FPCA
        assert rig.cpu.get(Reg.PSP) == rig.RAM + 0x200

    def test_exc_return_of_handler_mode(self, rig):
        enter(rig)
        begin_context(rig)
        sp = enter(rig, irq=1, priority=0x40)
        assert sp == rig.STACK_TOP - BASIC - EXTENDED
        assert rig.cpu.get(Reg.LR) == 0xFFFF_FFE1
        rig.exit()
        assert rig.core.running == Number.FIRST_IRQ
        assert rig.cpu.get(Reg.CONTROL) == FPCA
        rig.exit(0xFFFF_FFF9)
        assert rig.cpu.get(Reg.CONTROL) == 0

    def test_what_the_handler_changes_comes_back(self, rig):
        begin_context(rig)
        enter(rig)
        rig.cpu.use_floats(*[0xDEAD] * 32)
        rig.cpu.put_float(32, 0x0340_0000)
        rig.exit()
        assert rig.cpu.floats[:16] == SINGLES
        assert rig.cpu.floats[16:32] == [0xDEAD] * 16  # S16 and up are the handler's to save
        assert rig.cpu.floats[32] == FPSCR

    def test_flags_of_dsp_instructions_stay_at_entry(self, rig):
        rig.cpu.set(Reg.XPSR, 1 << 24 | 0xA << 16)
        enter(rig)
        assert rig.cpu.get(Reg.XPSR) == 1 << 24 | 0xA << 16 | 16

    def test_a_stack_that_is_not_there(self, rig):
        begin_context(rig)
        rig.cpu.set(Reg.MSP, 0x1000)
        enter(rig)
        assert rig.core.last_fault.causes == ("STKERR",)


class TestLazyStacking:
    def test_it_is_pending_until_the_handler_uses_floating_point(self, rig):
        begin_context(rig)
        sp = enter(rig)
        assert rig.peek("FPU", "FPCCR") & LSPACT
        assert rig.peek("FPU", "FPCAR") == sp + 32
        rig.cpu.use_floats(1)
        assert not rig.peek("FPU", "FPCCR") & LSPACT
        assert rig.peek("FPU", "FPCAR") == sp + 32

    def test_return_ends_it(self, rig):
        begin_context(rig)
        enter(rig)
        rig.exit()
        assert not rig.peek("FPU", "FPCCR") & LSPACT
        assert rig.cpu.floats[:16] == SINGLES

    def test_what_was_not_used_is_not_read_back(self, rig):
        begin_context(rig)
        sp = enter(rig)
        rig.memory.write(sp + 32, 4, 0xBAD)
        rig.exit()
        assert rig.cpu.floats[0] == SINGLES[0]

    def test_a_frame_made_by_hand_is_read(self, rig):
        """As when a kernel goes to a task that has used floating point, from one that has not."""
        enter(rig)
        frame = rig.RAM + 0x100
        for index, word in enumerate([1, 2, 3, 4, 12, 0, rig.MAIN, 1 << 24, *SINGLES, FPSCR]):
            rig.memory.write(frame + 4 * index, 4, word)
        rig.cpu.set(Reg.PSP, frame)
        rig.exit(0xFFFF_FFED)
        assert rig.cpu.floats[:16] == SINGLES
        assert rig.cpu.floats[32] == FPSCR
        assert rig.cpu.get(Reg.PSP) == frame + EXTENDED
        assert rig.cpu.get(Reg.CONTROL) == FPCA | SPSEL

    def test_a_task_without_a_context_after_one_with(self, rig):
        begin_context(rig)
        enter(rig)
        rig.cpu.use_floats(7)  # vstmdb: the kernel saves S16 and up
        frame = rig.RAM + 0x100
        for index, word in enumerate([1, 2, 3, 4, 12, 0, rig.MAIN, 1 << 24]):
            rig.memory.write(frame + 4 * index, 4, word)
        rig.cpu.set(Reg.PSP, frame)
        rig.exit(0xFFFF_FFFD)
        assert rig.cpu.get(Reg.PSP) == frame + BASIC
        assert rig.cpu.get(Reg.CONTROL) == SPSEL
        assert rig.cpu.floats[0] == 7

    def test_a_nested_handler_preserves_for_the_outer_one(self, rig):
        """The outer handler does not use floating point, the inner one does: the room is the thread's."""
        begin_context(rig)
        room = enter(rig) + 32
        inner = enter(rig, irq=1, priority=0x40)
        assert room - 32 - inner == BASIC
        assert rig.cpu.get(Reg.LR) == 0xFFFF_FFF1
        assert rig.peek("FPU", "FPCCR") & LSPACT
        assert rig.peek("FPU", "FPCAR") == room
        rig.cpu.use_floats(9)
        rig.exit()
        assert not rig.peek("FPU", "FPCCR") & LSPACT
        rig.exit(0xFFFF_FFE9)
        assert rig.cpu.floats[:16] == SINGLES

    def test_a_nested_handler_has_room_of_its_own(self, rig):
        begin_context(rig)
        outer = enter(rig)
        begin_context(rig, [5] * 16, 0)
        inner = enter(rig, irq=1, priority=0x40)
        assert outer - inner == EXTENDED
        assert rig.peek("FPU", "FPCCR") & LSPACT
        assert rig.peek("FPU", "FPCAR") == inner + 32
        rig.cpu.use_floats(6)
        rig.exit()
        assert rig.cpu.floats[:16] == [5] * 16
        assert not rig.peek("FPU", "FPCCR") & LSPACT
        rig.exit(0xFFFF_FFE9)
        assert rig.cpu.floats[:16] == SINGLES

    def test_tail_chaining_keeps_it(self, rig):
        begin_context(rig)
        sp = enter(rig)
        rig.interrupt(1, priority=0xC0)
        rig.settle()
        cycle = rig.cpu.cycle
        rig.exit()
        assert rig.core.running == Number.FIRST_IRQ + 1
        assert rig.cpu.cycle == cycle + TAIL_CHAIN_CYCLES
        assert rig.cpu.get(Reg.LR) == 0xFFFF_FFE9
        assert rig.cpu.get(Reg.MSP) == sp
        assert rig.peek("FPU", "FPCCR") & LSPACT
        rig.exit()
        assert rig.cpu.floats[:16] == SINGLES

    def test_a_handler_that_used_it_and_is_tail_chained(self, rig):
        begin_context(rig)
        enter(rig)
        rig.cpu.use_floats(3)
        rig.interrupt(1, priority=0xC0)
        rig.exit()
        assert rig.core.running == Number.FIRST_IRQ + 1
        assert rig.cpu.get(Reg.CONTROL) == 0
        assert not rig.peek("FPU", "FPCCR") & LSPACT
        rig.exit()
        assert rig.cpu.floats[:16] == SINGLES

    @pytest.mark.parametrize(
        ("control", "exception", "expected"),
        [(0, None, THREAD), (NPRIV, None, THREAD | USER), (0, 0, 0), (NPRIV, 0, 0)],
    )
    def test_whose_it_is(self, rig, control, exception, expected):
        if exception is not None:
            enter(rig)
        rig.cpu.set(Reg.CONTROL, control)
        begin_context(rig)
        enter(rig, irq=1, priority=0x40)
        assert rig.peek("FPU", "FPCCR") & (THREAD | USER) == expected

    def test_what_could_be_taken(self, rig):
        begin_context(rig)
        enter(rig)
        assert rig.peek("FPU", "FPCCR") & (HFRDY | MMRDY | BFRDY | MONRDY) == HFRDY
        rig.exit()
        rig.poke("SCB", "SHCSR", 1 << 16 | 1 << 17)
        rig.poke("SCB", "DEMCR", 1 << 16)
        enter(rig)
        assert rig.peek("FPU", "FPCCR") & (HFRDY | MMRDY | BFRDY | MONRDY) == HFRDY | MMRDY | BFRDY | MONRDY
        rig.exit()
        rig.poke("SCB", "SHPR1", 0x0000_E020)  # MemManage above, BusFault below what runs
        enter(rig, priority=0x80)
        begin_context(rig)
        enter(rig, irq=1, priority=0x10)
        assert rig.peek("FPU", "FPCCR") & (HFRDY | MMRDY | BFRDY) == HFRDY | MMRDY

    def test_not_lazy(self, rig):
        rig.poke("FPU", "FPCCR", ASPEN)
        begin_context(rig)
        cycle = rig.cpu.cycle
        sp = enter(rig)
        assert rig.cpu.cycle == cycle + ENTRY_CYCLES + FLOAT_CYCLES
        assert rig.peek("FPU", "FPCCR") == ASPEN
        rig.memory.write(sp + 32, 4, 0xF00D)
        rig.exit()
        assert rig.cpu.cycle == cycle + ENTRY_CYCLES + RETURN_CYCLES + 2 * FLOAT_CYCLES
        assert rig.cpu.floats[0] == 0xF00D

    @pytest.mark.parametrize(("lazy", "cause"), [(LSPEN, None), (0, ("NOCP",))])
    def test_a_context_that_nobody_may_store_at_entry(self, rig, lazy, cause):
        """As in QEMU: the frame has room for it, and the fault comes before the handler."""
        rig.poke("FPU", "FPCCR", ASPEN | lazy)
        begin_context(rig)
        rig.poke("SCB", "CPACR", 0)
        assert enter(rig) == rig.STACK_TOP - EXTENDED
        fault = rig.core.last_fault
        assert (None if fault is None else fault.causes) == cause
        assert rig.core.running == (16 if cause is None else Number.HARD_FAULT)

    def test_lazy_costs_nothing_until_it_is_used(self, rig):
        begin_context(rig)
        cycle = rig.cpu.cycle
        enter(rig)
        rig.exit()
        assert rig.cpu.cycle == cycle + ENTRY_CYCLES + RETURN_CYCLES


class TestModes:
    def test_a_context_begins_with_the_defaults_and_the_flags_there_are(self, rig):
        rig.poke("FPU", "FPDSCR", 0xFFFF_FFFF)
        assert rig.peek("FPU", "FPDSCR") == 0x07C0_0000
        begin_context(rig, fpscr=0x8000_0010)
        enter(rig)
        rig.cpu.use_floats(1)
        assert rig.cpu.floats[32] == 0x87C0_0010

    def test_flags_that_a_handler_leaves(self, rig):
        enter(rig)
        begin_context(rig, fpscr=0x0340_0011)
        rig.exit()
        assert rig.cpu.get(Reg.CONTROL) == 0
        rig.cpu.use_floats(1)
        assert rig.cpu.floats[32] == 0x11

    def test_not_automatic(self, rig):
        rig.poke("FPU", "FPCCR", LSPEN)
        rig.cpu.use_floats(1)
        assert rig.cpu.get(Reg.CONTROL) == 0
        assert enter(rig) == rig.STACK_TOP - BASIC

    def test_reset(self, rig):
        begin_context(rig)
        rig.poke("FPU", "FPDSCR", 0x0100_0000)
        enter(rig)
        rig.core.reset(rig.VECTORS)
        assert rig.cpu.get(Reg.CONTROL) == 0
        assert rig.cpu.floats == [*SINGLES, *[0] * 17]
        assert rig.cpu.float_access is FloatAccess.NOBODY
        assert rig.cpu.float_context == (True, 0)
        assert rig.peek("FPU", "FPCCR") == ASPEN | LSPEN


class TestAccess:
    @pytest.mark.parametrize(
        ("cpacr", "access"),
        [
            (0xF << 20, FloatAccess.EVERYBODY),
            (0x5 << 20, FloatAccess.PRIVILEGED),
            (0xA << 20, FloatAccess.NOBODY),
            (0, FloatAccess.NOBODY),
        ],
    )
    def test_cpacr(self, m7, cpacr, access):
        assert m7.cpu.float_access is FloatAccess.NOBODY
        m7.poke("SCB", "CPACR", cpacr | 0xFF)
        assert m7.peek("SCB", "CPACR") == cpacr
        assert m7.cpu.float_access is access

    def test_fields_that_differ(self, m7):
        m7.poke("SCB", "CPACR", 0x3 << 20)
        assert "SCB_CPACR" in m7.chip.noted("misuse")

    @pytest.mark.parametrize(
        ("first", "second", "cpacr", "control", "cause"),
        [
            (0xEE30, 0x0A20, 0x0, 0, "NOCP"),
            (0xEE30, 0x0A20, 0x5, NPRIV, "NOCP"),
            (0xEE30, 0x0A20, 0x5, 0, "UNDEFINSTR"),
            (0xEC20, 0x0A10, 0xF, 0, "UNDEFINSTR"),  # nothing in ARMv7-M
            (0xEE30, 0x0920, 0xF, 0, "NOCP"),  # coprocessor 9
            (0xFE80, 0x0B00, 0x0, 0, "NOCP"),  # vsel.f64
            (0xEF30, 0x0A20, 0x0, 0, "UNDEFINSTR"),
        ],
    )
    def test_what_an_instruction_lacks(self, m7, first, second, cpacr, control, cause):
        m7.memory.write(m7.MAIN, 4, second << 16 | first)
        m7.poke("SCB", "CPACR", cpacr << 20)
        m7.cpu.set(Reg.CONTROL, control)
        m7.fault(FaultKind.UNDEFINED)
        assert m7.core.last_fault.causes == (cause,)
        assert m7.core.last_fault.pc == m7.MAIN

    def test_registers_that_nobody_may_use_do_not_come_back(self, rig):
        begin_context(rig)
        enter(rig)
        rig.cpu.use_floats(1)
        rig.poke("SCB", "CPACR", 0)
        rig.exit()
        assert rig.core.last_fault.causes == ("NOCP",)

    @each("exc_return", [0xFFFF_FFE1, 0xFFFF_FFE9, 0xFFFF_FFED])
    def test_a_core_without_floating_point_has_no_such_frames(self, make_rig, exc_return):
        rig = make_rig(CORTEX_M3)
        enter(rig)
        rig.exit(exc_return)
        assert rig.core.last_fault.causes == ("INVPC",)
