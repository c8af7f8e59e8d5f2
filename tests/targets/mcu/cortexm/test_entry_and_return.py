"""Stack frames, EXC_RETURN, cycles of entry, return and tail-chaining, late arrival."""

from __future__ import annotations

import pytest

from targets.mcu.cortexm.exceptions import Number
from targets.mcu.engine.api import Reg

NMI, PENDSV, SYSTICK = Number.NMI, Number.PENDSV, Number.SYSTICK
IN_FRAME = (Reg.R0, Reg.R1, Reg.R2, Reg.R3, Reg.R12, Reg.LR)


def give_registers_values(rig):
    for place, register in enumerate(IN_FRAME):
        rig.cpu.set(register, 0x1111_1111 * (place + 1))
    rig.cpu.set(Reg.PC, 0x0800_0ABC)
    rig.cpu.set(Reg.XPSR, 0xA100_0000)


def frame_at(rig, address):
    return [rig.memory.read(address + 4 * index, 4) for index in range(8)]


class TestFrame:
    def test_words_from_the_stack_pointer_up(self, rig):
        give_registers_values(rig)
        rig.interrupt(0)
        rig.settle()
        sp = rig.cpu.get(Reg.MSP)
        assert sp == rig.STACK_TOP - 32
        expected = [0x1111_1111 * n for n in range(1, 7)] + [0x0800_0ABC, 0xA100_0000]
        assert frame_at(rig, sp) == expected
        assert rig.cpu.get(Reg.LR) == 0xFFFF_FFF9
        assert rig.cpu.get(Reg.PC) == rig.handler(16)
        assert rig.cpu.get(Reg.XPSR) == 0xA100_0010

    def test_bytes_are_little_endian(self, rig):
        rig.cpu.set(Reg.R0, 0x0403_0201)
        rig.interrupt(0)
        rig.settle()
        assert rig.memory.dump(rig.cpu.get(Reg.MSP), 4) == b"\x01\x02\x03\x04"

    @pytest.mark.parametrize("align", [False, True])
    @pytest.mark.parametrize("offset", [0, 4])
    def test_alignment(self, rig, align, offset):
        rig.poke("SCB", "CCR", 0x200 if align else 0)
        rig.cpu.set(Reg.MSP, rig.STACK_TOP - 16 - offset)
        give_registers_values(rig)
        rig.interrupt(0)
        rig.settle()
        padding = offset if align else 0
        sp = rig.cpu.get(Reg.MSP)
        assert sp == rig.STACK_TOP - 16 - offset - 32 - padding
        assert frame_at(rig, sp)[7] == 0xA100_0000 | (0x200 if padding else 0)
        rig.exit()
        assert rig.cpu.get(Reg.MSP) == rig.STACK_TOP - 16 - offset
        assert rig.cpu.get(Reg.XPSR) == 0xA100_0000

    def test_everything_comes_back(self, rig):
        give_registers_values(rig)
        before = dict(rig.cpu.registers)
        rig.interrupt(0)
        rig.settle()
        for register in IN_FRAME:
            if register is not Reg.LR:
                rig.cpu.set(register, 0xDEAD)
        rig.exit()
        assert rig.cpu.registers == before

    def test_it_state_is_in_the_frame(self, rig):
        rig.cpu.set(Reg.XPSR, 0x0700_FC00 | 1 << 24)
        rig.interrupt(0)
        rig.settle()
        assert rig.cpu.get(Reg.XPSR) == 0x0100_0010
        rig.exit()
        assert rig.cpu.get(Reg.XPSR) == 0x0700_FC00

    def test_stack_pointer_wraps_in_32_bits(self, rig):
        rig.cpu.set(Reg.MSP, 0)
        rig.interrupt(0)
        rig.settle()
        assert rig.cpu.get(Reg.MSP) == 0xFFFF_FFE0
        assert rig.core.last_fault.causes == ("STKERR",)  # nothing is there

    def test_bit_0_of_a_return_address_is_ignored_without_a_word(self, rig):
        """UNPREDICTABLE by DDI0403 section B1.5.8; M3 and M7 ignore it, and kernels stack what BX takes."""
        rig.interrupt(0)
        rig.settle()
        sp = rig.cpu.get(Reg.MSP)
        rig.memory.write(sp + 24, 4, rig.MAIN | 1)
        rig.exit()
        assert rig.cpu.get(Reg.PC) == rig.MAIN
        assert rig.chip.noted("misuse") == []


class TestStacks:
    @pytest.fixture
    def on_psp(self, rig):
        rig.cpu.set(Reg.PSP, rig.RAM + 0x200)
        rig.cpu.set(Reg.CONTROL, 2)
        return rig

    def test_process_stack_is_used_by_thread_mode_alone(self, on_psp):
        rig = on_psp
        rig.interrupt(1, priority=0x80)
        rig.settle()
        assert rig.cpu.get(Reg.PSP) == rig.RAM + 0x200 - 32
        assert rig.cpu.get(Reg.MSP) == rig.STACK_TOP
        assert rig.cpu.get(Reg.SP) == rig.STACK_TOP
        assert rig.cpu.get(Reg.LR) == 0xFFFF_FFFD
        assert rig.cpu.get(Reg.CONTROL) == 0
        rig.interrupt(0, priority=0x40)
        rig.settle()
        assert rig.cpu.get(Reg.MSP) == rig.STACK_TOP - 32
        assert rig.cpu.get(Reg.LR) == 0xFFFF_FFF1
        rig.exit()
        assert rig.core.running == 17
        rig.exit(0xFFFF_FFFD)
        assert rig.cpu.get(Reg.CONTROL) == 2
        assert rig.cpu.get(Reg.SP) == rig.RAM + 0x200

    def test_a_handler_can_switch_stacks(self, on_psp):
        """As PendSV does in every kernel: another PSP, a frame made by hand."""
        rig = on_psp
        rig.poke("SCB", "ICSR", 1 << 28)
        rig.settle()
        assert rig.core.running == PENDSV
        other = rig.RAM + 0x100
        for index, word in enumerate([1, 2, 3, 4, 12, 0xFFFF_FFFF, 0x0800_0F00, 0x0100_0000]):
            rig.memory.write(other + 4 * index, 4, word)
        rig.cpu.set(Reg.PSP, other)
        rig.exit()
        assert rig.cpu.get(Reg.PC) == 0x0800_0F00
        assert rig.cpu.get(Reg.R0) == 1
        assert rig.cpu.get(Reg.R12) == 12
        assert rig.cpu.get(Reg.SP) == other + 32

    def test_starting_the_first_thread_with_a_supervisor_call(self, rig):
        rig.svc()
        assert rig.core.running == Number.SVCALL
        other = rig.RAM + 0x100
        for index, word in enumerate([0, 0, 0, 0, 0, 0, 0x0800_0F00, 0x0100_0000]):
            rig.memory.write(other + 4 * index, 4, word)
        rig.cpu.set(Reg.PSP, other)
        rig.exit(0xFFFF_FFFD)
        assert rig.cpu.get(Reg.CONTROL) == 2
        assert rig.cpu.get(Reg.PC) == 0x0800_0F00

    def test_privilege_is_kept(self, rig):
        rig.cpu.set(Reg.CONTROL, 3)
        rig.cpu.set(Reg.PSP, rig.RAM + 0x200)
        rig.svc()
        assert rig.cpu.get(Reg.CONTROL) == 1
        rig.exit()
        assert rig.cpu.get(Reg.CONTROL) == 3


class TestCycles:
    def test_entry_and_return_take_twelve_each(self, rig):
        rig.interrupt(0)
        rig.settle()
        assert rig.taken == [(16, 12)]
        rig.exit()
        assert rig.cpu.cycle == 24

    def test_tail_chaining_takes_six(self, rig):
        rig.interrupt(0)
        rig.settle()
        rig.interrupt(1)
        rig.settle()
        assert rig.began == [16]
        sp = rig.cpu.get(Reg.MSP)
        writes = len(rig.memory.accesses)
        rig.exit()
        assert rig.taken == [(16, 12), (17, 18)]
        assert rig.cpu.get(Reg.MSP) == sp
        assert rig.cpu.get(Reg.LR) == 0xFFFF_FFF9
        assert [access[0] for access in rig.memory.accesses[writes:]] == ["read"]  # the vector alone
        rig.exit()
        assert rig.cpu.cycle == 30
        assert rig.cpu.get(Reg.PC) == rig.MAIN

    def test_tail_chaining_goes_above_the_level_returned_to_only(self, rig):
        rig.interrupt(0, priority=0x40)
        rig.settle()
        rig.interrupt(1, priority=0x20)
        rig.settle()
        rig.interrupt(2, priority=0x60)
        rig.settle()
        rig.exit()
        assert rig.core.running == 16
        assert rig.began == [16, 17]
        rig.exit()
        assert rig.began == [16, 17, 18]

    def test_supervisor_call(self, rig):
        pc = rig.cpu.get(Reg.PC)
        rig.svc()
        assert rig.taken == [(11, 12)]
        assert frame_at(rig, rig.cpu.get(Reg.MSP))[6] == pc + 2


class TestLateArrival:
    def at(self, rig, cycle, irq, priority):
        rig.core.exceptions.set_priority(16 + irq, priority)
        rig.core.exceptions.enable(16 + irq)
        rig.chip.time.at(cycle, lambda: rig.core.exceptions.pend(16 + irq))

    @pytest.mark.parametrize("cycle", [1, 11, 12])
    def test_a_more_urgent_one_within_the_entry_goes_first(self, rig, cycle):
        self.at(rig, cycle, 1, 0x10)
        rig.interrupt(0, priority=0x20)
        rig.settle()
        assert rig.taken == [(17, 12)]
        assert rig.core.exceptions.is_pending(16)
        assert rig.cpu.get(Reg.LR) == 0xFFFF_FFF9
        rig.exit()
        assert rig.taken == [(17, 12), (16, 18)]

    def test_after_the_entry_it_preempts(self, rig):
        self.at(rig, 13, 1, 0x10)
        rig.interrupt(0, priority=0x20)
        rig.settle()
        rig.advance(1)
        assert rig.taken == [(16, 12), (17, 25)]
        assert rig.cpu.get(Reg.LR) == 0xFFFF_FFF1

    def test_a_less_urgent_one_waits(self, rig):
        self.at(rig, 5, 1, 0x30)
        rig.interrupt(0, priority=0x20)
        rig.settle()
        assert rig.began == [16]

    def test_within_a_tail_chain(self, rig):
        rig.interrupt(0, priority=0x20)
        rig.settle()
        rig.interrupt(1, priority=0x20)
        self.at(rig, 15, 2, 0x10)
        rig.exit()
        assert rig.taken == [(16, 12), (18, 18)]

    @pytest.mark.parametrize("cycle", [13, 24])
    def test_within_a_return_nothing_is_unstacked(self, rig, cycle):
        rig.interrupt(0, priority=0x20)
        rig.settle()
        self.at(rig, cycle, 1, 0x30)
        rig.exit()
        assert rig.taken == [(16, 12), (17, 30)]
        assert rig.cpu.get(Reg.MSP) == rig.STACK_TOP - 32

    def test_the_loop_can_stop_between_the_steps(self, rig):
        rig.interrupt(0, priority=0x20)
        assert rig.core.take()
        assert rig.core.can_take()
        assert rig.core.running == 0
        rig.core.exceptions.set_priority(17, 0x10)
        rig.core.exceptions.enable(17)
        rig.core.exceptions.pend(17)
        rig.settle()
        assert rig.began == [17]


class TestMasks:
    def test_primask(self, rig):
        rig.cpu.set(Reg.PRIMASK, 1)
        rig.interrupt(0)
        rig.settle()
        assert rig.began == []
        rig.poke("SCB", "ICSR", 1 << 31)
        rig.settle()
        assert rig.began == [NMI]
        rig.exit()
        assert rig.cpu.get(Reg.PRIMASK) == 1
        rig.cpu.set(Reg.PRIMASK, 0)
        rig.settle()
        assert rig.began == [NMI, 16]

    @pytest.mark.parametrize(
        ("basepri", "taken"), [(0x00, True), (0x50, True), (0x40, False), (0x3F, False), (0x0F, True)]
    )
    def test_basepri(self, rig, basepri, taken):
        rig.cpu.set(Reg.BASEPRI, basepri)
        rig.interrupt(0, priority=0x40)
        rig.settle()
        assert bool(rig.began) is taken

    def test_faultmask_ends_with_the_handler(self, rig):
        rig.interrupt(0)
        rig.settle()
        rig.cpu.set(Reg.FAULTMASK, 1)
        rig.interrupt(1, priority=0)
        rig.exit()
        assert rig.cpu.get(Reg.FAULTMASK) == 0
        assert rig.began == [16, 17]

    def test_faultmask_outlasts_nmi(self, rig):
        rig.cpu.set(Reg.FAULTMASK, 1)
        rig.poke("SCB", "ICSR", 1 << 31)
        rig.settle()
        assert rig.began == [NMI]
        rig.exit()
        assert rig.cpu.get(Reg.FAULTMASK) == 1


def test_nmi_runs_again_while_its_line_is_high(rig):
    """As the clock security system demands until CSSC is written (RM0008 section 7.2.7)."""
    rig.cpu.set(Reg.FAULTMASK, 1)
    rig.core.set_nmi(True)
    rig.settle()
    rig.exit()
    assert rig.began == [NMI, NMI]
    rig.core.set_nmi(False)
    rig.exit()
    assert rig.core.running == 0


class TestVectors:
    def test_vtor(self, rig):
        table = rig.RAM + 0x100
        rig.memory.write(table + 4 * 16, 4, 0x0800_0F01)
        rig.poke("SCB", "VTOR", table)
        rig.interrupt(0)
        rig.settle()
        assert rig.cpu.get(Reg.PC) == 0x0800_0F00

    def test_reset(self, rig):
        assert rig.cpu.get(Reg.PC) == rig.MAIN
        assert rig.cpu.get(Reg.MSP) == rig.STACK_TOP
        assert rig.cpu.get(Reg.LR) == 0xFFFF_FFFF
        assert rig.cpu.get(Reg.XPSR) == 1 << 24
        assert rig.core.running == 0

    def test_reset_from_a_handler(self, rig):
        rig.cpu.set(Reg.PSP, rig.RAM + 0x200)
        rig.cpu.set(Reg.CONTROL, 3)
        rig.interrupt(0)
        rig.settle()
        rig.interrupt(1)
        rig.cpu.set(Reg.PRIMASK, 1)
        rig.core.reset(rig.VECTORS)
        assert rig.cpu.get(Reg.CONTROL) == 0
        assert rig.cpu.get(Reg.PRIMASK) == 0
        assert rig.core.exceptions.active == rig.core.exceptions.pending == 0
        assert rig.cpu.get(Reg.PC) == rig.MAIN
        assert not rig.core.can_take()

    def test_the_stack_pointer_loses_its_low_bits(self, rig):
        rig.memory.write(rig.VECTORS, 4, rig.STACK_TOP - 1)
        rig.core.reset(rig.VECTORS)
        assert rig.cpu.get(Reg.MSP) == rig.STACK_TOP - 4

    def test_the_monitor_of_exclusive_accesses_is_cleared(self, rig):
        rig.cpu.mark()
        rig.interrupt(0)
        rig.settle()
        assert not rig.cpu.is_marked
        rig.cpu.mark()
        rig.exit()
        assert not rig.cpu.is_marked
