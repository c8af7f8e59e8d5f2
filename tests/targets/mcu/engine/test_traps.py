"""Divisions by zero and unaligned accesses as faults, on request."""

from __future__ import annotations

import struct

import pytest

from targets.mcu.engine.api import FaultKind, Reg, Stop, StopKind
from targets.mcu.engine.traps import find_divisions

NOP, HANG = 0xBF00, 0xE7FE
SDIV, UDIV = (0xFB91, 0xF2F0), (0xFBB1, 0xF2F0)  # r2 = r1 / r0
DIVISION = Stop(StopKind.FAULT, fault=FaultKind.DIVISION)


@pytest.fixture
def trapping(machine):
    machine.engine.set_traps(division=True, unaligned=True)
    machine.engine.set(Reg.R1, 100)
    return machine


@pytest.fixture(params=["flat", "table"])
def any_timing(request, make):
    machine = make(request.param)
    machine.engine.set_traps(division=True, unaligned=True)
    return machine


class TestDivision:
    @pytest.mark.parametrize("divide", [SDIV, UDIV], ids=["sdiv", "udiv"])
    def test_by_zero_is_a_fault_of_the_instruction(self, any_timing, at, divide):
        engine = any_timing.engine
        engine.set(Reg.R2, 77)
        any_timing.load(NOP, *divide, HANG)
        cycle = engine.cycle
        assert any_timing.engine.run(cycle + 50) == DIVISION
        assert engine.get(Reg.PC) == at.code + 2
        assert engine.get(Reg.R2) == 77
        assert engine.instructions == 1
        assert engine.cycle == cycle + 1

    def test_by_anything_else_is_none(self, trapping):
        trapping.engine.set(Reg.R0, 3)
        trapping.load(*UDIV, HANG)
        assert trapping.run().kind is StopKind.LIMIT
        assert trapping.engine.get(Reg.R2) == 33

    def test_one_that_its_condition_passes_over_is_none(self, trapping):
        trapping.load(0x2800, 0xBF18, *UDIV, HANG)  # cmp r0, #0; it ne; udivne
        assert trapping.run().kind is StopKind.LIMIT

    @pytest.mark.parametrize(("mask", "place"), [(8, 0), (4, 0), (4, 1), (2, 1), (1, 0), (1, 2), (1, 3)])
    def test_by_zero_in_an_it_block(self, any_timing, at, mask, place):
        """Nothing that comes behind it in the block may happen."""
        engine, length = any_timing.engine, 4 - (mask & -mask).bit_length() + 1
        engine.set(Reg.R2, 77)
        engine.set(Reg.XPSR, 1 << 24 | 1 << 30)
        body = [[0x3301], [0x3301], [0x3301], [0x3301]][:length]  # adds r3, #1
        body[place] = UDIV
        any_timing.load(0xBF00 | mask, *(half for halves in body for half in halves), HANG)
        assert any_timing.engine.run(engine.cycle + 50) == DIVISION
        assert engine.get(Reg.PC) == at.code + 2 + 2 * place
        assert (engine.get(Reg.R2), engine.get(Reg.R3)) == (77, place)
        assert engine.instructions == 1 + place
        engine.set(Reg.R0, 5)
        engine.set(Reg.R1, 100)
        any_timing.run()
        assert (engine.get(Reg.R2), engine.get(Reg.R3)) == (20, length - 1)

    def test_it_can_be_switched_on_and_off_for_code_that_has_run(self, machine, at):
        machine.load(*UDIV, HANG)
        for wanted in (False, True, False, True):
            machine.engine.set_traps(division=wanted, unaligned=False)
            machine.engine.set(Reg.PC, at.code)
            assert (machine.run() == DIVISION) == wanted

    def test_one_that_is_programmed_later_is_found(self, trapping):
        trapping.load(NOP, NOP, HANG)
        trapping.run()
        trapping.load(*UDIV, HANG)
        assert trapping.run() == DIVISION

    def test_asking_for_it_ends_the_slice(self, machine, at):
        machine.on_access = lambda _kind, _offset: machine.engine.set_traps(division=True, unaligned=False)
        machine.engine.set(Reg.R3, at.registers)
        machine.load(0x601B, *UDIV, HANG)  # str r3, [r3]
        assert machine.run().kind is StopKind.LIMIT
        assert machine.engine.get(Reg.PC) == at.code + 2
        assert machine.run() == DIVISION


class TestUnaligned:
    @pytest.mark.parametrize(
        ("halves", "address"),
        [
            ((0x6801,), 1),  # ldr r1, [r0]
            ((0x6801,), 2),
            ((0x8801,), 3),  # ldrh
            ((0x6001,), 2),  # str
            ((0x8001,), 1),  # strh
            ((0xE9D0, 0x2300), 2),  # ldrd r2, r3, [r0]
            ((0xC00C,), 1),  # stmia r0!, {r2, r3}
        ],
    )
    def test_is_a_fault_of_the_instruction(self, any_timing, at, halves, address):
        engine = any_timing.engine
        engine.set(Reg.R0, at.ram + address)
        any_timing.load(NOP, *halves, NOP, HANG)
        cycle = engine.cycle
        assert any_timing.engine.run(cycle + 50) == Stop(
            StopKind.FAULT, fault=FaultKind.UNALIGNED, address=at.ram + address
        )
        assert engine.get(Reg.PC) == at.code + 2
        assert engine.instructions == 1
        assert engine.cycle == cycle + 1

    @pytest.mark.parametrize("load", [0x6801, 0x8801, 0x7801])  # ldr, ldrh, ldrb
    def test_aligned_is_none(self, trapping, at, load):
        trapping.engine.set(Reg.R0, at.ram + {0x6801: 4, 0x8801: 2, 0x7801: 1}[load])
        trapping.load(load, HANG)
        assert trapping.run().kind is StopKind.LIMIT

    def test_where_nothing_is_it_is_still_unaligned(self, trapping):
        trapping.engine.set(Reg.R0, 0x6000_0001)
        trapping.load(NOP, 0x6801, HANG)
        assert trapping.run().fault is FaultKind.UNALIGNED
        assert trapping.engine.instructions == 1

    def test_not_any_more(self, trapping, at):
        trapping.engine.set(Reg.R0, at.ram + 1)
        trapping.load(0x6801, HANG)
        trapping.run()
        trapping.engine.set_traps(division=True, unaligned=False)
        assert trapping.run().kind is StopKind.LIMIT


def test_divisions_are_found_at_even_addresses_only():
    code = struct.pack("<7H", 0xFBFB, *SDIV, 0x00FB, 0xF4FB, 0xF5F6, 0xFBB9)
    assert list(find_divisions(code)) == [(2, 0)]
    assert list(find_divisions(struct.pack("<4H", 0xFBB3, 0xF4F7, 0xFB93, 0xF4FE))) == [(0, 7), (4, 14)]
    assert list(find_divisions(struct.pack("<4H", 0xFBA3, 0xF4F7, 0xFB93, 0x04FE))) == []
