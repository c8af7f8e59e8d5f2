"""The engine as the machine around it sees it: counting, slices, stops, accesses, code that changes."""

from __future__ import annotations

from typing import ClassVar

import pytest

from targets.mcu.engine.api import FaultKind, Reg, StopKind
from targets.mcu.errors import BusFault
from tests.each import each

NOP, WFI, WFE, YIELD, SEV, HANG = 0xBF00, 0xBF30, 0xBF20, 0xBF10, 0xBF40, 0xE7FE
LDR_R0_R1, STR_R0_R1, STR_R0_R1_4, ADDS_R0, BX_R1 = 0x6808, 0x6008, 0x6048, 0x3001, 0x4708


class TestCounting:
    def test_a_slice_ends_at_its_limit_and_counts_what_retired(self, machine, at):
        machine.load(*[ADDS_R0] * 20, HANG)
        stop = machine.run(7)
        assert stop.kind is StopKind.LIMIT
        assert machine.engine.instructions == 7
        assert machine.engine.get(Reg.R0) == 7
        assert machine.engine.get(Reg.PC) == at.code + 14

    def test_slicing_does_not_change_the_count(self, make):
        whole, cut = make(), make()
        code = [ADDS_R0, 0xBF08, 0x3101, NOP, 0xE7FA]  # adds; it eq; addeq r1; nop; b to the start
        for machine in (whole, cut):
            machine.load(*code)
        whole.run(1000)
        for _ in range(1000):
            if cut.engine.instructions >= 1000:
                break
            cut.run(1)
        assert cut.engine.instructions == whole.engine.instructions
        assert cut.regs() == whole.regs()
        assert cut.engine.cycle == whole.engine.cycle

    def test_an_access_sees_the_cycle_at_which_its_instruction_began(self, machine, at):
        machine.engine.set(Reg.R1, at.registers)
        machine.load(NOP, NOP, LDR_R0_R1, NOP, STR_R0_R1_4, HANG)
        machine.run(6)
        cycle = machine.engine.timing.cycle
        assert machine.log == [("read", 0, 4, cycle(2)), ("write", 4, 4, 0, cycle(4))]

    def test_stop_by_ends_after_the_instruction_in_flight_and_does_nothing_twice(self, machine, at):
        machine.on_access = lambda _kind, _offset: machine.engine.stop_by(0)
        machine.engine.set(Reg.R1, at.registers)
        machine.load(NOP, STR_R0_R1, ADDS_R0, HANG)
        stop = machine.run(50)
        assert stop.kind is StopKind.LIMIT
        assert machine.engine.instructions == 2
        assert len(machine.log) == 1
        machine.run(2)
        assert (len(machine.log), machine.engine.get(Reg.R0)) == (1, 1)

    def test_stop_by_counts_from_the_instruction_in_flight(self, machine, at):
        engine = machine.engine
        machine.on_access = lambda _kind, _offset: engine.stop_by(engine.cycle + 10)
        engine.set(Reg.R1, at.registers)
        machine.load(STR_R0_R1, *[ADDS_R0] * 50, HANG)
        machine.run(40)
        assert engine.cycle == 10  # eight instructions of 5/4 cycles
        assert engine.instructions == 8

    def test_added_and_skipped_cycles(self, machine):
        engine = machine.engine
        machine.load(HANG)
        machine.run(4)
        engine.add_cycles(12)
        assert engine.cycle == 5 + 12
        engine.skip_periods(28, 4, 5)
        assert (engine.cycle, engine.instructions) == (27, 12)

    def test_wait_states_change_the_rate_from_there_on(self, machine):
        engine = machine.engine
        machine.load(HANG)
        machine.run(4)
        engine.set_wait_states(2)
        machine.run(4)
        assert engine.cycle == 5 + 6


class TestMasks:
    @pytest.mark.parametrize(
        "halves",
        [(0xB662,), (0xB661,), *[(0xF380, 0x8800 | register) for register in (16, 17, 18, 19)]],
        ids=["cpsie-i", "cpsie-f", "primask", "basepri", "basepri-max", "faultmask"],
    )
    @pytest.mark.parametrize("wanted", [True, False])
    def test_a_slice_ends_where_one_may_go_if_asked(self, machine, at, halves, wanted):
        machine.load(NOP, *halves, NOP, HANG)
        machine.engine.until_unmasked = wanted
        assert machine.run(20).kind is StopKind.LIMIT
        assert machine.engine.instructions == (2 if wanted else 20)
        assert machine.engine.get(Reg.PC) == at.code + 2 * len(halves) + (2 if wanted else 4)

    @pytest.mark.parametrize("halves", [(0xB672,), (0xF380, 0x8808), (0xF380, 0x8814)], ids=["cpsid", "msp", "control"])
    def test_it_does_not_where_none_can_go(self, machine, halves):
        machine.load(NOP, *halves, NOP, HANG)
        machine.engine.until_unmasked = True
        machine.run(20)
        assert machine.engine.instructions == 20


class TestItBlocks:
    @pytest.mark.parametrize("place", ["ram", "registers", "flash"])
    @pytest.mark.parametrize("access", [LDR_R0_R1, STR_R0_R1])
    def test_an_access_leaves_no_condition_behind(self, machine, at, place, access):
        # cmp r2, r2; itt eq; access; addeq r3; movs r4, #1 (Z is clear); bx r5
        machine.load(0x4292, 0xBF04, access, 0x3301, 0x2401, 0x4728, HANG, 0x3601, 0x3701, HANG)
        machine.engine.set(Reg.R1, getattr(at, place) + 0x800 * (place != "registers"))
        machine.engine.set(Reg.R5, at.code + 15)
        machine.run(20)
        machine.run(20)  # a store to flash ends a slice
        assert [machine.engine.get(reg) for reg in (Reg.R3, Reg.R6, Reg.R7)] == [1, 1, 1]

    @each("z", [True, False])
    @each("mask", [0x4, 0xC, 0x2, 0x6, 0xA, 0xE, 0x1, 0xF, 0x5])
    def test_no_slice_ends_inside(self, make, mask, z):
        length = 4 - (mask & -mask).bit_length() + 1

        def ends(step):
            machine = make()
            machine.engine.set(Reg.XPSR, 1 << 24 | (z << 30))
            machine.load(NOP, 0xBF00 | mask, *[ADDS_R0] * length, NOP, NOP, HANG)
            seen = []
            for _ in range(12):
                machine.run(step)
                assert machine.engine.get(Reg.XPSR) & 0x0600_FC00 == 0
                seen.append((machine.engine.instructions, machine.regs()))
            return seen

        stepped = ends(1)
        for step in range(2, 8):
            found = [end for end in ends(step) if end[0] <= stepped[-1][0]]
            assert found
            assert all(end in stepped for end in found)

    @pytest.mark.parametrize("access", [LDR_R0_R1, STR_R0_R1])
    @pytest.mark.parametrize("where", ["ram", "registers"])
    def test_an_access_does_not_carry_conditions_beyond_the_block(self, machine, at, access, where):
        engine = machine.engine
        engine.set(Reg.R1, getattr(at, where) + 0x200 * (where == "ram"))
        engine.set(Reg.R2, 5)
        # movs r5, #0; ite eq; access; bne; adds r4, #1; subs r2, #1; adds r3, #1
        machine.load(0x2500, 0xBF0C, access, 0xE000, 0x3401, 0x3A01, 0x3301, HANG)
        machine.run(7)
        assert [engine.get(register) for register in (Reg.R2, Reg.R3, Reg.R4)] == [4, 1, 1]
        assert engine.get(Reg.XPSR) == 0x0100_0000

    @pytest.mark.parametrize("step", [1, 2, 3])
    def test_a_slice_ends_behind_a_write_to_the_stack_pointer_in_one(self, machine, at, step):
        """The limit comes before it, within the block: itt eq; addeq r2, #1; moveq sp, r1; adds r3, #1."""
        machine.engine.set(Reg.XPSR, 1 << 24 | 1 << 30)
        machine.engine.set(Reg.R1, at.ram + 0x203)
        machine.load(0xBF04, 0x3201, 0x468D, 0x3301, 0xDF00)
        assert machine.engine.run(1 << 40, step).kind is StopKind.LIMIT
        assert machine.engine.get(Reg.PC) == at.code + 6
        machine.engine.run(1 << 40, 4 - machine.engine.instructions)
        assert [machine.engine.get(register) for register in (Reg.R2, Reg.SP, Reg.R3)] == [1, at.ram + 0x200, 1]


class TestStops:
    def test_svc(self, machine, at):
        machine.load(NOP, 0xDF2A, NOP, HANG)
        stop = machine.run()
        assert (stop.kind, stop.value) == (StopKind.SVC, 0x2A)
        assert (machine.engine.instructions, machine.engine.get(Reg.PC)) == (2, at.code + 4)

    def test_breakpoint_stays_where_it_is(self, machine, at):
        machine.load(NOP, 0xBEAB, NOP, HANG)
        for _ in range(2):
            stop = machine.run()
            assert (stop.kind, stop.value) == (StopKind.BREAKPOINT, 0xAB)
            assert (machine.engine.instructions, machine.engine.get(Reg.PC)) == (1, at.code + 2)

    @pytest.mark.parametrize(
        ("halves", "kind"),
        [
            ((WFI,), StopKind.WFI),
            ((0xF3AF, 0x8003), StopKind.WFI),
            ((WFE,), StopKind.WFE),
            ((0xF3AF, 0x8002), StopKind.WFE),
            ((SEV,), StopKind.SEV),
            ((0xF3AF, 0x8004), StopKind.SEV),
        ],
    )
    def test_hints(self, machine, at, halves, kind):
        machine.load(NOP, *halves, ADDS_R0, HANG)
        assert machine.run().kind is kind
        assert machine.engine.instructions == 2
        assert machine.engine.get(Reg.PC) == at.code + 2 + 2 * len(halves)
        assert machine.run(1).kind is StopKind.LIMIT
        assert machine.engine.get(Reg.R0) == 1

    @pytest.mark.parametrize("place", ["flash", "ram"])
    def test_a_hint_within_an_it_block(self, machine, at, place):
        """itt eq; seveq; addeq r0, #1: the block goes on behind it."""
        start = getattr(at, place) + 0x200
        machine.engine.set(Reg.XPSR, 1 << 24 | 1 << 30)
        machine.load(0xBF04, SEV, ADDS_R0, HANG, at=start)
        assert machine.run().kind is StopKind.SEV
        assert (machine.engine.instructions, machine.engine.get(Reg.PC)) == (2, start + 4)
        machine.run(1)
        assert (machine.engine.get(Reg.R0), machine.engine.get(Reg.XPSR)) == (1, 1 << 24 | 1 << 30)

    @pytest.mark.parametrize("halves", [(YIELD,), (0xF3AF, 0x8001)])
    def test_yield_does_nothing(self, machine, halves):
        machine.load(NOP, *halves, ADDS_R0, HANG)
        assert machine.run(10).kind is StopKind.LIMIT
        assert machine.engine.instructions == 10
        assert machine.engine.get(Reg.R0) == 1

    def test_undefined(self, machine, at):
        machine.load(NOP, 0xDE00, NOP)
        stop = machine.run()
        assert (stop.kind, stop.fault) == (StopKind.FAULT, FaultKind.UNDEFINED)
        assert (machine.engine.instructions, machine.engine.get(Reg.PC)) == (1, at.code + 2)

    def test_arm_state(self, machine, at):
        machine.engine.set(Reg.R1, at.code + 0x40)
        machine.load(NOP, BX_R1)
        stop = machine.run()
        assert (stop.kind, stop.fault) == (StopKind.FAULT, FaultKind.STATE)
        assert (machine.engine.instructions, machine.engine.get(Reg.PC)) == (2, at.code + 0x40)

    @pytest.mark.parametrize(
        ("half", "kind"), [(LDR_R0_R1, FaultKind.READ), (STR_R0_R1, FaultKind.WRITE), (BX_R1, FaultKind.FETCH)]
    )
    def test_where_nothing_is(self, machine, at, half, kind):
        machine.engine.set(Reg.R1, 0x6000_0101 if half == BX_R1 else 0x6000_0100)
        machine.load(NOP, half, NOP, HANG)
        stop = machine.run()
        assert (stop.kind, stop.fault, stop.address) == (StopKind.FAULT, kind, 0x6000_0100)
        retired = 2 if half == BX_R1 else 1
        assert machine.engine.instructions == retired
        assert machine.engine.get(Reg.PC) == (0x6000_0100 if half == BX_R1 else at.code + 2)

    def test_fetch_from_registers_is_a_fault(self, machine, at):
        machine.engine.set(Reg.R1, at.registers | 1)
        machine.load(NOP, BX_R1)
        stop = machine.run()
        assert (stop.kind, stop.fault) == (StopKind.FAULT, FaultKind.FETCH)

    @pytest.mark.parametrize("how", ["bx", "pop"])
    @pytest.mark.parametrize("value", [0xFFFF_FFF1, 0xFFFF_FFF9, 0xFFFF_FFFD])
    def test_exception_return(self, machine, at, how, value):
        machine.load(*((BX_R1,) if how == "bx" else (0xB500, 0xBD00)), NOP)  # push {lr}; pop {pc}
        machine.engine.set(Reg.XPSR, 1 << 24 | 22)
        machine.engine.set(Reg.R1, value)
        machine.engine.set(Reg.LR, value)
        stop = machine.run()
        assert (stop.kind, stop.value) == (StopKind.EXCEPTION_RETURN, value)

    def test_exception_return_after_ipsr_was_written_between_slices(self, machine):
        machine.load(NOP, NOP, BX_R1)
        machine.run(1)
        machine.engine.set(Reg.XPSR, 1 << 24 | 3)
        machine.engine.set(Reg.R1, 0xFFFF_FFF9)
        assert machine.run().kind is StopKind.EXCEPTION_RETURN

    def test_exc_return_in_thread_mode_is_a_jump_to_nowhere(self, machine):
        machine.engine.set(Reg.R1, 0xFFFF_FFF9)
        machine.load(NOP, BX_R1)
        assert machine.run().fault is FaultKind.FETCH

    def test_stack_pointers_follow_mode_and_control(self, machine, at):
        engine = machine.engine
        engine.set(Reg.MSP, at.ram + 0x800)
        engine.set(Reg.PSP, at.ram + 0x400)
        engine.set(Reg.CONTROL, 2)
        assert engine.get(Reg.SP) == at.ram + 0x400
        engine.set(Reg.XPSR, 1 << 24 | 11)
        assert engine.get(Reg.SP) == at.ram + 0x800
        engine.set(Reg.XPSR, 1 << 24)
        assert engine.get(Reg.SP) == at.ram + 0x400
        assert (engine.get(Reg.MSP), engine.get(Reg.PSP)) == (at.ram + 0x800, at.ram + 0x400)

    def test_an_exception_in_an_access_comes_out_after_the_instruction(self, machine, at):
        def fail(_kind, _offset):
            raise KeyboardInterrupt

        machine.on_access = fail
        machine.engine.set(Reg.R1, at.registers)
        machine.load(NOP, STR_R0_R1, ADDS_R0, HANG)
        with pytest.raises(KeyboardInterrupt):
            machine.run()
        machine.on_access = lambda _kind, _offset: None
        machine.run(1)
        assert (len(machine.log), machine.engine.get(Reg.R0)) == (1, 1)

    @pytest.mark.parametrize("half", [LDR_R0_R1, STR_R0_R1])
    def test_a_register_that_answers_with_a_bus_fault(self, machine, at, half):
        def fail(_kind, offset):
            raise BusFault(at.registers + offset)

        machine.on_access = fail
        machine.engine.set(Reg.R1, at.registers)
        machine.load(NOP, half, ADDS_R0, HANG)
        stop = machine.run()
        kind = FaultKind.READ if half == LDR_R0_R1 else FaultKind.WRITE
        assert (stop.kind, stop.fault, stop.address) == (StopKind.FAULT, kind, at.registers)
        assert (machine.engine.instructions, machine.engine.get(Reg.PC)) == (1, at.code + 2)

    def test_a_limit_in_instructions(self, machine):
        machine.load(ADDS_R0, YIELD, ADDS_R0, YIELD, ADDS_R0, HANG)
        for expected in (2, 4):
            assert machine.engine.run(1000, 2).kind is StopKind.LIMIT
            assert machine.engine.instructions == expected

    def test_exclusive_monitor(self, machine, at):
        # ldrex r0, [r1]; strex r2, r3, [r1]
        machine.load(0xE851, 0x0F00, 0xE841, 0x3200, HANG)
        machine.engine.set(Reg.R1, at.ram)
        machine.engine.set(Reg.R3, 77)
        machine.run(1)
        machine.run(1)
        assert machine.engine.get(Reg.R2) == 0
        assert machine.ram[0] == 77


class TestCodeThatChanges:
    def test_flash_stores_are_handed_on_in_order(self, machine, at):
        engine = machine.engine
        machine.load(NOP, 0xC10C, ADDS_R0, HANG)  # stmia r1!, {r2, r3}
        engine.set(Reg.R1, at.flash + 0x800)
        engine.set(Reg.R2, 0x1111_2222)
        engine.set(Reg.R3, 0x3333_4444)
        machine.run(2)
        assert machine.stores == [(at.flash + 0x800, 4, 0x1111_2222), (at.flash + 0x804, 4, 0x3333_4444)]
        assert machine.flash[0x800:0x808] == b"\xff" * 8
        assert engine.get(Reg.R0) == 0

    def test_a_flash_store_does_not_carry_conditions_beyond_its_it_block(self, machine, at):
        engine = machine.engine
        engine.set(Reg.R1, at.flash + 0x1000)
        engine.set(Reg.R2, 5)
        # str; movs r5, #0; ite eq; streq; bne; adds r4, #1; subs r2, #1; adds r3, #1
        machine.load(STR_R0_R1, 0x2500, 0xBF0C, STR_R0_R1, 0xE000, 0x3401, 0x3A01, 0x3301, HANG)
        while engine.instructions < 9:
            machine.run(1)
        assert [engine.get(register) for register in (Reg.R2, Reg.R3, Reg.R4)] == [4, 1, 1]
        assert len(machine.stores) == 2

    @pytest.mark.parametrize(("store", "size"), [(0x7008, 1), (0x8008, 2), (0x6008, 4)])
    def test_flash_stores_of_every_size_into_a_page_that_runs(self, machine, at, store, size):
        machine.load(store, NOP, HANG)
        machine.engine.set(Reg.R1, at.code + 0x80)
        machine.engine.set(Reg.R0, 0x1234_5678)
        machine.run(3)
        machine.engine.set(Reg.PC, at.code)
        machine.run(3)
        assert machine.stores == [(at.code + 0x80, size, 0x1234_5678 & (1 << 8 * size) - 1)] * 2

    def test_code_written_by_the_owner_of_the_memory_runs_after_forget(self, machine):
        machine.load(0x2005, HANG)
        machine.run(2)
        machine.load(0x2006, HANG)
        machine.run(2)
        assert machine.engine.get(Reg.R0) == 6

    def test_code_in_ram_that_rewrites_itself(self, machine, at):
        # the caller, in flash, stores "movs r0, #n" into RAM and calls it, again and again
        ram = at.ram + 0x200
        machine.load(0x2000, 0x4770, at=ram)  # movs r0, #0; bx lr
        for number in range(5):
            machine.load(0x8001, 0x4790, HANG)  # strh r1, [r0]; blx r2
            machine.engine.set(Reg.R0, ram)
            machine.engine.set(Reg.R1, 0x2000 | number)
            machine.engine.set(Reg.R2, ram | 1)
            machine.run(6)
            assert machine.engine.get(Reg.R0) == number

    def test_code_beside_data_in_one_page_of_ram(self, machine, at):
        # code in RAM that counts in a word of its own page: adds r1, #1; str r1, [r0]; b
        machine.load(0x3101, 0x6001, 0xE7FC, at=at.ram + 0x200)
        machine.engine.set(Reg.R0, at.ram + 0x240)
        machine.engine.set(Reg.R1, 0)
        machine.run(300)
        assert int.from_bytes(machine.ram[0x240:0x244], "little") == 100

    def test_a_hint_that_is_programmed_later_is_noticed(self, machine):
        machine.load(NOP, NOP, HANG)
        machine.run(3)
        machine.load(NOP, SEV, HANG)
        assert machine.run().kind is StopKind.SEV


class TestWithoutPrivilege:
    """What unprivileged code may not see, the machine around it sees all the same."""

    VALUES: ClassVar = {Reg.MSP: 0x2000_0800, Reg.PSP: 0x2000_0400, Reg.BASEPRI: 0x40, Reg.PRIMASK: 1, Reg.FAULTMASK: 1}

    @pytest.mark.parametrize("control", [1, 3])
    def test_registers_are_read(self, machine, control):
        engine = machine.engine
        for register, value in self.VALUES.items():
            engine.set(register, value)
        engine.set(Reg.CONTROL, control)
        assert {register: engine.get(register) for register in self.VALUES} == self.VALUES
        assert engine.get(Reg.SP) == self.VALUES[Reg.PSP if control & 2 else Reg.MSP]
        assert engine.get(Reg.CONTROL) == control

    @pytest.mark.parametrize("control", [1, 3])
    def test_registers_are_written(self, machine, control):
        engine = machine.engine
        engine.set(Reg.XPSR, 0x6100_0000)
        engine.set(Reg.CONTROL, control)
        for register, value in self.VALUES.items():
            engine.set(register, value)
        assert engine.get(Reg.CONTROL) == control
        assert engine.get(Reg.XPSR) == 0x6100_0000
        engine.set(Reg.CONTROL, 0)
        assert {register: engine.get(register) for register in self.VALUES} == self.VALUES

    def test_privilege_and_stack_are_given_back(self, machine):
        engine = machine.engine
        engine.set(Reg.MSP, 0x2000_0800)
        engine.set(Reg.PSP, 0x2000_0400)
        engine.set(Reg.CONTROL, 3)
        engine.set(Reg.CONTROL, 0)
        assert engine.get(Reg.CONTROL) == 0
        assert engine.get(Reg.SP) == 0x2000_0800
