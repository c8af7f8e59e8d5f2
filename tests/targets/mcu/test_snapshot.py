"""A machine goes on from a snapshot as it went on from there the first time, however often, and unchanged by it."""

from __future__ import annotations

from functools import partial
from random import Random

import pytest

from targets.mcu.engine.hooks import Watchpoint
from targets.mcu.machine import Machine
from targets.mcu.nets import Nets
from targets.mcu.snapshot import NotSaved, Snapshot
from targets.mcu.trace import Trace
from tests.targets.firmware.wires import PARTS, put_wires
from tests.targets.mcu.traces.goldens import difference, lines_of
from tests.targets.mcu.traces.scenarios import SCENARIOS, load

MS = 1_000_000
FEW = ("style-kernel", "echo-dma", "bad-iwdg-loop", "selftest-flash", "f767-demo", "h753-demo")
OTHERS = pytest.mark.exhaustive("a snapshot within each image; the gate has half a dozen, of each family")


def machine_of(scenario):
    machine = Machine(scenario.board, load(scenario.image, scenario.board), timing=scenario.timing)
    put_wires(machine, scenario.image)
    for one in scenario.inputs:
        machine.at_ns(one.ns, partial(one.act, machine))
    return machine


def goes_on(machine, *stops_ns):
    """Return the trace of what comes next."""
    recorder = Trace(machine)
    for stop_ns in stops_ns:
        machine.run_to(stop_ns)
    return recorder.close()


OF_CHIPS = [name for name, scenario in SCENARIOS.items() if scenario.image not in PARTS]


@pytest.mark.parametrize("name", [name if name in FEW else pytest.param(name, marks=OTHERS) for name in OF_CHIPS])
def test_it_goes_on_the_same_way_again(name):
    scenario, chance = SCENARIOS[name], Random(name)
    machine, end = machine_of(scenario), scenario.span_ns
    for cut in sorted(chance.randrange(1, end) for _ in range(2)):
        machine.run_to(cut)
        snapshot = Snapshot(machine)
        first = goes_on(machine, end)
        assert first[-1] == lines_of(name)[-1], "to take it has changed the run"
        snapshot.restore()
        assert not difference(first, goes_on(machine, end)), cut
        snapshot.restore()
        assert not difference(first, goes_on(machine, chance.randrange(cut, end + 1), end)), cut
        snapshot.restore()


def test_one_can_be_put_back_after_another():
    """An older one after a newer one, and the newer one after that."""
    scenario = SCENARIOS["style-kernel"]
    machine = machine_of(scenario)
    machine.run_to(7 * MS)
    older = Snapshot(machine)
    machine.run_to(31 * MS)
    newer = Snapshot(machine)
    expected = goes_on(machine, 60 * MS)
    older.restore()
    assert machine.now_ns == 7 * MS
    machine.run_to(12 * MS)
    newer.restore()
    assert machine.now_ns == 31 * MS
    assert not difference(expected, goes_on(machine, 60 * MS))


def test_one_of_a_machine_that_stands_at_a_hit():
    machine = machine_of(SCENARIOS["style-kernel"])
    machine.engine.hooks.watchpoints = [Watchpoint(0x4001_0800, 0x400, reads=True)]
    machine.run_to(60 * MS)
    hit, snapshot = machine.hit, Snapshot(machine)
    ways = []
    for _ in range(2):
        assert machine.hit == hit is not None
        way = []
        for _ in range(5):
            machine.run_to(60 * MS)
            way.append((machine.cycle, machine.hit))
        ways.append(way)
        snapshot.restore()
    assert ways[0] == ways[1]


class Slave:
    """What is soldered to a bus."""


def test_what_is_no_part_of_the_chip_is_refused():
    machine = machine_of(SCENARIOS["style-kernel"])
    machine.chip.pins["PA0"].on_edge(lambda *_: None)
    Snapshot(machine)
    machine.chip.i2cs["I2C1"].bus.attach(Slave())
    with pytest.raises(NotSaved, match=r"bus\.slaves\[\.\.\.\]: .*test_snapshot\.Slave is no part of the chip"):
        Snapshot(machine)


def test_a_chip_that_is_wired_to_another_is_refused():
    """Its wires lead to the other's pins, and from there to all that the other consists of."""
    machine, other = (machine_of(SCENARIOS["style-kernel"]) for _ in range(2))
    Nets().wire("between", machine.chip.pins["PA2"], other.chip.pins["PA3"])
    with pytest.raises(NotSaved, match=r"\S+: a wire leads to another chip"):
        Snapshot(machine)


def test_within_a_run_there_is_none():
    machine = machine_of(SCENARIOS["style-kernel"])
    machine.run_to(7 * MS)
    snapshot, troubles = Snapshot(machine), []

    def look(*_edge):
        if machine.engine.running:
            for attempt in (partial(Snapshot, machine), snapshot.restore):
                with pytest.raises(ValueError, match="between two runs, not within one"):
                    attempt()
                troubles.append(attempt)

    for pin in machine.chip.pins:
        pin.on_edge(look)
    machine.run_to(60 * MS)
    assert troubles
