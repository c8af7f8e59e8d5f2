"""Code that is followed computes what the engine computes, for one run and for many at once."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from hypothesis import event, given, reject, settings
from hypothesis import strategies as st

from targets.mcu.engine.api import Reg
from targets.mcu.engine.follower import FLAGS, Follower, NotUnderstood
from targets.mcu.engine.follower_steps import step
from tests.share import examples
from tests.targets.mcu.engine.conftest import Machine
from tests.targets.mcu.engine.thumb_code import BASE, BASE_REGISTER, NARROW, WIDE, stretches

SETS = 4

words = st.one_of(st.integers(0, (1 << 32) - 1), st.sampled_from([0, 1, 31, 32, 0x7FFF_FFFF, 1 << 31, (1 << 32) - 1]))
registers = st.lists(words, min_size=13, max_size=13)


class Before:
    """What the engine had before it executed."""

    def __init__(self, machine):
        self.half = machine.engine.half
        self._registers = struct.unpack(f"<{len(Reg)}I", machine.engine.fingerprint())
        self._ram = bytes(machine.ram)

    def core_register(self, number):
        return self._registers[number]

    def memory(self, address, size):
        if address >= 0x2000_0000:
            at = address - 0x2000_0000
            return int.from_bytes(self._ram[at : at + size], "little")
        return self.half(address) | self.half(address + 2) << 16

    def register(self, _address, _size):
        return None


def set_up(machine, values, flags):
    for number, value in enumerate(values):
        machine.engine.set(Reg(number), value)
    machine.engine.set(Reg(BASE_REGISTER), BASE)
    machine.engine.set(Reg.SP, BASE)
    machine.engine.set(Reg.XPSR, 1 << 24 | flags << 28)
    machine.ram[:] = bytes(index * 7 & 0xFF for index in range(len(machine.ram)))


def found(machine, places):
    """Return what is in places after the engine has executed."""
    after, xpsr = Before(machine), machine.engine.get(Reg.XPSR)
    values = []
    for place in places:
        if isinstance(place, tuple):
            values.append(after.memory(*place))
        else:
            values.append(bool(xpsr >> place & 1) if place in FLAGS else after.core_register(place))
    return values


@pytest.fixture(scope="module")
def machine():
    return Machine()


@settings(max_examples=examples(120))
@given(stretches(), st.lists(st.tuples(registers, st.integers(0, 15)), min_size=SETS, max_size=SETS))
def test_it_computes_what_the_engine_computes(machine, items, sets):
    code = [half for item in items for halves in item for half in halves]
    machine.load(*code, *[0xBF00] * 4)
    start = machine.engine.pc()
    set_up(machine, *sets[0])
    turn = Follower(Before(machine), start)
    try:
        for _ in items:
            step(turn)
    except NotUnderstood as reason:
        event(str(reason).partition(" is ")[2] or str(reason))
        reject()
    assert turn.pc == start + 2 * len(code)
    graph, places = turn.graph, list(turn.ends)
    inputs = {place: [] for place in turn.starts}
    expected = []
    for values, flags in sets:
        machine.engine.set(Reg.PC, start)
        set_up(machine, values, flags)
        before = Before(machine)
        for place in turn.starts:
            inputs[place] += found(machine, [place])
        assert before.half(start) == code[0]
        for _ in items:
            machine.engine.run(1 << 60, 1)
        assert machine.engine.pc() == turn.pc
        expected.append(found(machine, places))
    assert [graph.value[turn.ends[place]] for place in places] == expected[0]
    vectors = {
        turn.starts[place]: np.array(given, dtype=bool if isinstance(given[0], bool) else np.uint64)
        for place, given in inputs.items()
    }
    graph.evaluate(range(len(graph.value)), vectors)
    for index in range(SETS):
        if all(at(vectors[node], index) == graph.value[node] for node in turn.conditions):
            assert [at(vectors[turn.ends[place]], index) for place in places] == expected[index]


def at(value, index):
    return value[index] if isinstance(value, np.ndarray) else value


def test_all_patterns_are_of_a_length():
    assert {len(pattern) for pattern in NARROW} == {16}
    assert {len(pattern) for pattern in WIDE} == {32}
