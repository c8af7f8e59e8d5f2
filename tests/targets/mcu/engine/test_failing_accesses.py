"""An access that fails leaves everything as it was before its instruction, wherever in an IT block that stands."""

from __future__ import annotations

import pytest

from targets.mcu.cortexm.stepping import advanced
from targets.mcu.engine.api import Access, FaultKind, Reg, StopKind
from targets.mcu.errors import BusFault

NOP, IT_EQ, HANG = 0xBF00, 0xBF00, 0xE7FE
Z, T = 1 << 30, 1 << 24
GOOD, REFUSED, NOWHERE, IN_FLASH, ODD = 0x4000_0010, 0x4000_0200, 0x3000_0000, 0x0800_2000, 0x2000_0101
# ldr r1, [r0]; str r1, [r0]; ldr.w r1, [r0, #0]!; str.w r1, [r0], #4
LOAD, STORE, PRE_LOAD, POST_STORE = (0x6801,), (0x6001,), (0xF850, 0x1F00), (0xF840, 0x1B04)
# What stands around it: adds r2, #1; str r2, [r3] in RAM; str r2, [r4] among the registers.
OTHERS = ((0x3201,), (0x601A,), (0x6022,))
CASES = {
    "register-load": (LOAD, REFUSED, FaultKind.READ, "not now"),
    "register-store": (STORE, REFUSED, FaultKind.WRITE, "not now"),
    "load-with-writeback": (PRE_LOAD, REFUSED, FaultKind.READ, "not now"),
    "store-with-writeback": (POST_STORE, REFUSED, FaultKind.WRITE, "not now"),
    "nothing-to-load": (LOAD, NOWHERE, FaultKind.READ, ""),
    "nothing-to-store": (STORE, NOWHERE, FaultKind.WRITE, ""),
    "nothing-to-store-with-writeback": (POST_STORE, NOWHERE, FaultKind.WRITE, ""),
    "flash-store": (STORE, IN_FLASH, FaultKind.WRITE, "locked"),
    "flash-store-with-writeback": (POST_STORE, IN_FLASH, FaultKind.WRITE, "locked"),
    "unaligned-load": (LOAD, ODD, FaultKind.UNALIGNED, ""),
    "unaligned-store": (STORE, ODD, FaultKind.UNALIGNED, ""),
}
PLACES = [
    (letters, place) for letters in ("TTTT", "TETE", "TTEE", "TEET") for place in range(4) if letters[place] == "T"
]


def state_of(machine, address):
    engine = machine.engine
    registers = [engine.get(register) for register in (Reg.R1, Reg.R2, Reg.SP, Reg.PC)]
    return (
        registers,
        engine.get(Reg.R0) - address,
        bytes(machine.ram),
        list(machine.log),
        engine.instructions,
        engine.cycle,
    )


@pytest.fixture
def execute(make, at):
    """Execute; return what is seen when `GOOD` is accessed, how it stopped, what is seen afterwards, and the engine."""

    def executed(timing, address, *halves):
        seen = []

        def answer(offset, *_):
            if at.registers + offset == GOOD:
                seen.append(state_of(machine, address))
            elif at.registers + offset == REFUSED:
                raise BusFault(REFUSED, "not now")
            else:
                machine.log.append(offset)
            return 0

        def refuse(where, _size, _value):
            raise BusFault(where, "locked")

        machine = make(timing, Access(answer, answer))
        machine.log.clear()
        engine = machine.engine
        engine.on_flash_store = refuse
        engine.set_traps(division=False, unaligned=True)
        for register, value in ((Reg.R0, address), (Reg.R1, 0x55), (Reg.R3, at.ram + 0x80), (Reg.R4, at.registers + 8)):
            engine.set(register, value)
        engine.set(Reg.XPSR, T | Z)
        machine.load(*halves, *[NOP] * 8, HANG)
        stop = engine.run(1 << 40, 20)
        return seen, stop, state_of(machine, address), engine

    return executed


@pytest.mark.parametrize("timing", ["flat", "table"])
@pytest.mark.parametrize("case", CASES)
def test_in_an_it_block(execute, timing, case):
    failing, address, kind, refusal = CASES[case]
    for letters, place in PLACES:
        mask = int("".join("01"[letter == "E"] for letter in letters[1:]) + "1", 2)
        block = [*OTHERS[:place], failing, *OTHERS[place:]]
        program = NOP, IT_EQ | mask, *(half for halves in block for half in halves)
        (expected,), *_ = execute(timing, GOOD, *program)

        _, stop, found, engine = execute(timing, address, *program)
        where = f"I{letters}, instruction {place}"
        assert (stop.kind, stop.fault, stop.address, stop.refusal) == (StopKind.FAULT, kind, address, refusal), where
        assert found == expected, where
        xpsr = T | Z | (mask & 3) << 25 | (mask & 0xFC) << 8
        for _ in range(place):
            xpsr = advanced(xpsr)
        assert engine.get(Reg.XPSR) == xpsr, where


@pytest.mark.parametrize("timing", ["flat", "table"])
@pytest.mark.parametrize("case", CASES)
def test_elsewhere(execute, timing, case):
    failing, address, kind, refusal = CASES[case]
    program = [half for halves in (*OTHERS, failing, *OTHERS) for half in halves]
    (expected,), *_ = execute(timing, GOOD, *program)
    _, stop, found, engine = execute(timing, address, *program)
    assert (stop.kind, stop.fault, stop.address, stop.refusal) == (StopKind.FAULT, kind, address, refusal)
    assert found == expected
    assert not engine.get(Reg.XPSR) & 0x0600_FC00


@pytest.mark.parametrize("timing", ["flat", "table"])
def test_it_can_be_executed_again(execute, at, timing):
    """With its condition and those behind it: itet eq; ldr; adds r2, #1 (not); adds r2, #1."""
    *_, engine = execute(timing, REFUSED, IT_EQ | 0b1010, *LOAD, 0x3201, 0x3201)
    assert engine.get(Reg.PC) == at.code + 2
    engine.set(Reg.R0, GOOD)
    engine.run(1 << 40, 6)
    assert (engine.get(Reg.R1), engine.get(Reg.R2)) == (0, 1)


def test_a_store_into_flash_before_it_stays_one(make, at):
    def refuse(offset, *_):
        raise BusFault(at.registers + offset)

    machine = make("flat", Access(refuse, refuse))
    engine = machine.engine
    for register, value in ((Reg.R0, at.flash + 0x800), (Reg.R1, 7), (Reg.R4, at.registers)):
        engine.set(register, value)
    engine.set(Reg.XPSR, T | Z)
    machine.load(IT_EQ | 0b0010, 0x6001, 0x6022, 0x6041, HANG)  # str r1, [r0]; str r2, [r4]; str r1, [r0, #4]
    assert engine.run(1 << 40, 9).address == at.registers
    assert machine.stores == [(at.flash + 0x800, 4, 7)]
    assert engine.get(Reg.PC) == at.code + 4
    assert machine.flash[0x800:0x808] == b"\xff" * 8


def test_the_second_of_two_stores_into_flash(make, at):
    def refuse_the_second(*store):
        if machine.stores:
            raise BusFault(store[0])
        machine.stores.append(store)

    machine = make()
    engine = machine.engine
    engine.on_flash_store = refuse_the_second
    engine.set(Reg.R0, at.flash + 0x800)
    engine.set(Reg.XPSR, T | Z)
    machine.load(IT_EQ | 0b0010, 0x6001, 0x6041, 0x3201, HANG)  # str r1, [r0]; str r1, [r0, #4]; adds r2, #1
    assert engine.run(1 << 40, 9).address == at.flash + 0x804
    assert (engine.get(Reg.PC), engine.get(Reg.R2), engine.instructions) == (at.code + 4, 0, 2)


def test_a_load_of_several_ends_where_it_fails(execute):
    (expected, *_), *_ = execute("flat", GOOD, 0xE890, 0x00E2)  # ldm.w r0, {r1, r5-r7}
    _, stop, found, _ = execute("flat", REFUSED, 0xE890, 0x00E2)
    assert (stop.fault, found) == (FaultKind.READ, expected)


def test_the_state_advances_as_the_manual_says():
    """ITAdvance, DDI0403 section A7.3.2."""
    for it in range(256):
        after = 0 if it & 7 == 0 else it & 0xE0 | it << 1 & 0x1F
        assert advanced(T | Z | (it & 3) << 25 | (it & 0xFC) << 8) == T | Z | (after & 3) << 25 | (after & 0xFC) << 8
