"""Registers that are set between two slices are there in the next, whatever mode and privilege are gone to."""

from __future__ import annotations

import itertools

import pytest

from targets.mcu.engine.api import Reg

NOP = 0xBF00
THUMB = 1 << 24
MODES = list(itertools.product((0, 1, 2, 3), (0, 3, 15)))
"""CONTROL and the number of the exception that runs."""


def values_for(control, running, salt=0):
    values = {
        reg: 0x1000_0000 * (reg + 1) + 4 * salt & 0xFFFF_FFFF for reg in Reg if reg <= Reg.LR and reg is not Reg.SP
    }
    special = {
        Reg.MSP: 0x2000_0800 + 8 * salt,
        Reg.PSP: 0x2000_0400 + 8 * salt,
        Reg.PRIMASK: 1,
        Reg.BASEPRI: 0x50 + salt,
    }
    return values | special | {Reg.FAULTMASK: salt & 1, Reg.CONTROL: control, Reg.XPSR: 0xA800_0000 | THUMB | running}


def set_all(engine, values):
    for register, value in values.items():
        engine.set(register, value)


def get_all(engine, values):
    return {register: engine.get(register) for register in values}


@pytest.mark.parametrize("before", MODES)
def test_from_every_mode_to_every_mode(machine, at, before):
    engine = machine.engine
    for after in MODES:
        machine.load(*[NOP] * 8)
        for salt, (control, running) in enumerate((before, after)):
            values = values_for(control, running, salt)
            set_all(engine, values)
            assert get_all(engine, values) == values, after
            engine.run(1 << 60, 1)
            assert get_all(engine, values) == values, after
            in_use = Reg.PSP if control & 2 and not running else Reg.MSP
            assert engine.get(Reg.SP) == values[in_use], after
        assert engine.get(Reg.PC) == engine.pc() == at.code + 4, after


def test_sp_is_the_stack_pointer_in_use(machine):
    engine = machine.engine
    set_all(engine, values_for(2, 0))
    engine.set(Reg.SP, 0x2000_0100)
    assert engine.get(Reg.PSP) == 0x2000_0100
    engine.set(Reg.XPSR, THUMB | 11)
    engine.set(Reg.SP, 0x2000_0200)
    assert (engine.get(Reg.MSP), engine.get(Reg.PSP)) == (0x2000_0200, 0x2000_0100)


def test_several_at_a_time(machine, at):
    engine = machine.engine
    machine.load(NOP, NOP)
    names = (Reg.R0, Reg.R12, Reg.LR, Reg.PC)
    engine.set_many(names, [1, 2, 3, at.code + 2])
    assert engine.get_many(names) == [1, 2, 3, at.code + 2]
    engine.run(1 << 60, 1)
    assert engine.get_many(names) == [1, 2, 3, at.code + 4]


def test_the_fingerprint_tells_states_apart_and_knows_the_same_one_again(machine, at):
    engine = machine.engine
    machine.load(0x1C40, 0x1E40, 0xE7FC)  # adds r0, r0, #1; subs r0, r0, #1; b to the start
    engine.run(1 << 60, 3)
    first = engine.fingerprint()
    engine.run(1 << 60, 1)
    assert engine.fingerprint() != first
    engine.run(1 << 60, 2)
    assert engine.fingerprint() == first
    engine.set(Reg.MSP, at.ram + 0x40)
    assert engine.fingerprint() != first
