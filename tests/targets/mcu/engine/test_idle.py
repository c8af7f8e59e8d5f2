"""What loops that change nothing cost: how often what they poll is read, and how many slices code takes that counts."""

from __future__ import annotations

import pytest

from targets.mcu.bus import Bus
from targets.mcu.engine.idle import IdleSkipper
from targets.mcu.fidelity import Notes
from targets.mcu.registers import Peripheral, Register
from targets.mcu.testing import FakeChip
from targets.mcu.timebase import Timebase

BASE = 0x4000_0000
POLL = [0x6808, 0x07C0, 0xD0FC]  # ldr r0, [r1]; lsls r0, r0, #31; beq to the start
COUNT = [0x3001, 0x2800, 0xD1FC]  # adds r0, #1; cmp r0, #0; bne to the start


class Status(Peripheral):
    REGISTERS = (Register("SR", 0), Register("CNT", 4, live=True))

    def __init__(self):
        super().__init__("STATUS", BASE, FakeChip(hclk_hz=72_000_000).services)
        self.reads = 0
        self.on_read = lambda: None

    def read(self, offset):
        self.reads += 1
        self.on_read()
        return super().read(offset)


class Rig:
    def __init__(self, make):
        self.status, self.time = Status(), Timebase(72_000_000)
        self.bus = Bus(Notes(lambda: (0, 0), lambda: None))
        self.bus.add(self.status)
        self.machine = make(access=self.bus.window(BASE))
        self.engine = self.machine.engine
        self.idle = IdleSkipper(self.engine, self.bus, self.time, self.machine.ram)

    def run(self, cycles):
        """Return how many slices it took."""
        end, slices = self.engine.cycle + cycles, 0
        while self.engine.cycle < end:
            self.idle.run(end)
            slices += 1
        return slices


@pytest.fixture
def rig(make):
    return Rig(make)


def test_a_loop_that_was_found_is_known_at_the_end_of_every_run(rig):
    rig.machine.load(*POLL)
    rig.engine.set(1, BASE)
    rig.run(10_000)
    for cycles in (*range(1000, 1016), 100_000, 1_000_000):
        rig.run(cycles)
        assert rig.idle.found is not None, cycles


def test_polling_a_flag_reads_it_a_few_times(rig):
    rig.machine.load(*POLL)
    rig.engine.set(1, BASE)
    assert rig.run(1_000_000) < 20
    assert rig.status.reads < 20
    assert rig.idle.found is not None
    assert rig.idle.found.polled == (BASE,)


def test_it_is_found_at_once_after_each_event(rig):
    rig.machine.load(*POLL)
    rig.engine.set(1, BASE)
    rig.run(1000)
    reads = rig.status.reads
    for _ in range(100):
        rig.idle.restart()
        rig.run(10_000)
    assert rig.status.reads - reads < 100 * 12


def test_a_counter_is_never_passed_over(rig):
    rig.machine.load(*POLL)
    rig.engine.set(1, BASE + 4)
    rig.run(10_000)
    assert rig.idle.found is None
    assert rig.status.reads == -(-rig.engine.instructions // 3)


def test_code_that_counts_is_left_alone_soon(rig):
    rig.machine.load(*COUNT)
    assert rig.run(2_000_000) < 400
    assert rig.idle.found is None


@pytest.mark.parametrize("number", range(1, 40))
def test_a_limit_that_a_read_has_lowered_holds(rig, number):
    rig.machine.load(*POLL)
    rig.engine.set(1, BASE)
    limits = []

    def lower():
        if rig.status.reads == number:
            limits.append(rig.engine.cycle + 300)
            rig.engine.stop_by(limits[0])

    rig.status.on_read = lower
    end = 5000
    while not limits and rig.engine.cycle < end:
        rig.idle.run(end)
    assert rig.engine.cycle <= (limits[0] if limits else end) + 3


def test_where_events_come_so_often_that_nothing_is_saved_it_executes(rig):
    rig.machine.load(0xE7FE)  # b to itself
    slices = 0
    for _ in range(1000):
        rig.idle.restart()
        slices += rig.run(400)
    assert slices < 1300
    rig.idle.restart()
    assert rig.run(10_000_000) < 10
