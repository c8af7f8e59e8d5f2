"""Parts at the I2C bus of a chip that runs ahead of the bench: what the file says, and when who is called."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from types import SimpleNamespace

import pytest

from hilbench.benchfile.bench_file import BusEnd, BusPins, PartPlan, PinEnd
from hilbench.benchfile.bench_model import BusPinsEntry, PartEntry
from hilbench.benchfile.bus_reader import BusReader
from hilbench.errors import UsageError
from hilbench.mcu import parts as wiring
from hilbench.mcu.buses import Buses
from hilbench.mcu.group import MachineGroup
from hilbench.mcu.parts import Parts
from hilbench.strict import Strict
from targets.mcu.pins import Pins
from targets.mcu.signals import Signals
from targets.mcu.stm32.i2c import I2c
from targets.mcu.testing import FakeChip, peek, poke
from targets.parts import Part

MS = 1_000_000
WRITE_NS = 5 * MS
"""A write cycle of a 24C02 (its data sheet, t_WR)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Written:
    at: int
    data: bytes


@dataclass
class Eeprom(Part):
    """A 24C02: it takes up to eight bytes, writes them after the STOP, and answers nothing while it writes."""

    settings: object
    ports: object
    seed: int = field(kw_only=True)

    BUSES = ("i2c",)

    def __post_init__(self):
        self.data = bytearray(256)
        self.pointer = 0
        self.page = bytearray()
        self.fresh = False
        self.ready_ns = None
        self.advanced = []

    def slave(self, name):
        return {"i2c": self}[name]

    def next_deadline_ns(self):
        return self.ready_ns

    def advance(self, now_ns):
        self.advanced.append(now_ns)
        self.ready_ns = None

    def address(self, address, read, now_ns):
        assert self.ready_ns is None or now_ns < self.ready_ns, "called beyond its own deadline"
        self.fresh = not read
        self.page.clear()
        return address == 0x50 and self.ready_ns is None

    def write(self, byte, _now_ns):
        if self.fresh:
            self.pointer, self.fresh = byte, False
        else:
            self.page.append(byte)
        return True

    def read(self, _now_ns):
        self.pointer += 1
        return self.data[self.pointer - 1]

    def end(self, now_ns):
        if self.page:
            self.data[self.pointer : self.pointer + len(self.page)] = self.page
            self.ports.tell(Written(at=self.pointer, data=bytes(self.page)))
            self.ready_ns = now_ns + WRITE_NS


class Machine:
    """A chip whose program is a test: real time, a real I2C interface, no CPU."""

    ended = None

    def __init__(self):
        self.tube = FakeChip(216_000_000)
        self.i2c = self.tube.add(
            I2c(
                "I2C1",
                0x4000_5400,
                self.tube.services,
                irq_event=31,
                irq_error=32,
                kernel_hz=lambda: Fraction(54_000_000),
            )
        )
        self.i2c.reset()
        poke(self.i2c, "TIMINGR", 0x0030_1C34)
        poke(self.i2c, "CR1", 1)
        signals = Signals(Pins((), self.tube.time, self.tube.notes))
        self.chip = SimpleNamespace(i2cs={"I2C1": self.i2c}, pins={}, signals=signals)
        self.reached = []
        self._limit_ns = 0

    def run_to(self, limit_ns):
        self._limit_ns = limit_ns
        time = self.tube.time
        while (due := time.next_cycle()) is not None and time.ns(due) <= self._limit_ns:
            time.run_due(due)
        time.run_due(max(time.now, time.cycle_at_ns(self._limit_ns)))
        self.reached.append(time.ns(time.now))

    def horizon(self, ns):
        self._limit_ns = min(self._limit_ns, max(ns, self.tube.time.ns(self.tube.time.now)))

    def send(self, at_ns, *data):
        """Have the program write bytes at a time."""
        queue = list(data)

        def serve(level):
            while level and queue and self.tube.dma("I2C1_TX").level:
                poke(self.i2c, "TXDR", queue.pop(0))

        def begin():
            self.tube.dma("I2C1_TX").on_set = serve
            poke(self.i2c, "ICR", 0x3F38)
            poke(self.i2c, "CR1", 1 | 1 << 14)
            poke(self.i2c, "CR2", 0x50 << 1 | 1 << 13 | 1 << 25 | len(data) << 16)

        self.tube.time.at_time(Fraction(at_ns, 10**9), begin)


@pytest.fixture
def rig(bench, monkeypatch):
    """One memory on the bus of one chip."""
    monkeypatch.setattr(wiring, "part_class", lambda _kind: Eeprom)
    machine = Machine()
    machines = {"brain": machine}
    group = MachineGroup(bench, machines, step_ns=10 * MS)
    plans = {"rom": PartPlan(kind="eeprom", settings=None, buses={"i2c": BusEnd(board="brain", interface="I2C1")})}
    parts = Parts(bench, plans, machines, (), seed=1)
    Buses(bench, group, machines, parts, plans)
    parts.power_on()
    return SimpleNamespace(bench=bench, machine=machine, parts=parts, rom=parts.by_name["rom"])


def events(rig, name):
    return [event for event in rig.bench.journal.recent if event.get("name") == name]


def test_a_transaction_is_one_event_at_its_end(rig):
    rig.machine.send(2 * MS, 0x10, 0xAA, 0xBB)
    rig.bench.run_for(0.010)
    assert rig.rom.data[0x10:0x12] == b"\xaa\xbb"
    (event,) = events(rig, "I2cTransaction")
    assert (event["source"], event["ns"]) == ("brain.i2c1", event["value"]["end_ns"])
    assert event["value"]["begin_ns"] == 2 * MS
    (message,) = event["value"]["messages"]
    assert (message["address"], message["data"], message["acknowledged"]) == (0x50, "10aabb", True)


def test_what_a_part_tells_is_in_the_journal_at_the_time_of_the_call(rig):
    told = []
    rig.parts.taps.append(lambda name, event: told.append((name, event, rig.bench.now_ns)))
    rig.machine.send(2 * MS, 0x10, 0xAA)
    rig.bench.run_for(0.010)
    (event,) = events(rig, "Written")
    (transaction,) = events(rig, "I2cTransaction")
    assert event["source"] == "rom"
    assert event["ns"] == transaction["ns"]
    assert told == [("rom", Written(at=0x10, data=b"\xaa"), event["ns"])]


def test_no_chip_runs_beyond_what_a_part_is_due_for_now(rig):
    """The second write comes just before the end of the first one's write cycle, the third just after."""
    rig.machine.send(2 * MS, 0x10, 1)
    rig.bench.run_for(0.0025)
    ready_ns = rig.rom.ready_ns
    rig.machine.send(ready_ns - 50_000, 0x10, 2)
    rig.machine.send(ready_ns + 1000, 0x10, 3)
    rig.bench.run_for(0.050)
    assert ready_ns in rig.machine.reached
    assert rig.rom.advanced[0] == ready_ns
    first, second, third = (event["value"]["messages"][0] for event in events(rig, "I2cTransaction"))
    assert [one["acknowledged"] for one in (first, second, third)] == [True, False, True]
    assert rig.rom.data[0x10] == 3


def test_a_part_is_due_within_a_transaction(rig, monkeypatch):
    """What it is due for comes before the next byte, however short it is after the last one: time never goes back."""
    rom, calls = rig.rom, []

    def write(_byte, now_ns):
        calls.append(now_ns)
        rom.ready_ns = now_ns + 7_000
        return True

    def advance(now_ns):
        calls.append(now_ns)
        rom.ready_ns = None

    monkeypatch.setattr(rom, "write", write)
    monkeypatch.setattr(rom, "advance", advance)
    monkeypatch.setattr(rom, "address", lambda _address, _read, now_ns: not calls.append(now_ns))
    monkeypatch.setattr(rom, "end", calls.append)
    rig.machine.send(2 * MS, 1, 2, 3)
    rig.bench.run_for(0.010)
    assert calls == sorted(calls)
    assert len(calls) == 1 + 3 + 3 + 1


def test_a_bus_without_parts_is_recorded_too(bench):
    machine = Machine()
    machines = {"brain": machine}
    group = MachineGroup(bench, machines, step_ns=10 * MS)
    Buses(bench, group, machines, Parts(bench, {}, machines, (), seed=1), {})
    machine.send(MS, 1)
    bench.run_for(0.005)
    (event,) = [event for event in bench.journal.recent if event.get("name") == "I2cTransaction"]
    assert not event["value"]["messages"][0]["acknowledged"]
    assert peek(machine.i2c, "ISR") & 1 << 4


def pin_end(_path, text):
    board, _, pin = text.partition(".")
    return PinEnd(board=board, pin=pin)


class TestReading:
    @pytest.fixture
    def reader(self):
        def board(*i2cs):
            return SimpleNamespace(board=SimpleNamespace(variant=SimpleNamespace(i2cs=i2cs)))

        boards = {"brain": board("I2C1", "I2C2"), "old": board()}
        strict = Strict(lambda path: "my.toml: " + ".".join(map(str, path)))
        return BusReader(boards, {"rom": Eeprom, "bare": Part}, strict, pin_end)

    def test_an_end_is_a_board_and_an_interface(self, reader):
        entry = PartEntry(kind="eeprom", buses={"i2c": "brain.i2c2"})
        assert reader.read("rom", entry) == {"i2c": BusEnd(board="brain", interface="I2C2")}
        assert str(BusEnd(board="brain", interface="I2C2")) == "brain.I2C2"
        assert reader.read("bare", PartEntry(kind="bare")) == {}

    def test_an_end_may_be_two_pins(self, reader):
        entry = PartEntry(kind="eeprom", buses={"i2c": BusPinsEntry(scl="brain.PB6", sda="brain.PB7")})
        assert reader.read("rom", entry) == {"i2c": BusPins(board="brain", scl="PB6", sda="PB7")}
        entry = PartEntry(kind="eeprom", buses={"i2c": BusPinsEntry(scl="brain.PB6", sda="old.PB7")})
        with pytest.raises(UsageError, match=r"brain\.PB6 and old\.PB7 are not two pins of one board"):
            reader.read("rom", entry)

    @pytest.mark.parametrize(
        ("name", "buses", "where", "what", "hint"),
        [
            ("rom", {"i2d": "brain.I2C1"}, "parts.rom.buses.i2d", "a kind has no bus 'i2d'", "did you mean 'i2c'?"),
            ("bare", {"i2c": "brain.I2C1"}, "parts.bare.buses.i2c", "a kind has no bus 'i2c'", "it has none"),
            ("rom", {}, "parts.rom", "'rom': its bus 'i2c' leads nowhere", 'add buses = { i2c = "brain.I2C1" }'),
            ("rom", {"i2c": "brian.I2C1"}, "parts.rom.buses.i2c", "'brian.I2C1' is no I2C interface of a board",
             "did you mean 'brain.I2C1'?"),
            ("rom", {"i2c": "brain.SPI"}, "parts.rom.buses.i2c", "'brain' has no I2C interface 'SPI'",
             "they are: I2C1, I2C2"),
            ("rom", {"i2c": "brain.I2C3"}, "parts.rom.buses.i2c", "'brain' has no I2C interface 'I2C3'",
             "did you mean 'I2C2'?"),
            ("rom", {"i2c": "old.I2C1"}, "parts.rom.buses.i2c", "'old' has no I2C interface 'I2C1'",
             "those of its chip are not modelled"),
        ],
    )  # fmt: skip
    def test_every_mistake_has_its_place_and_what_to_do(self, reader, name, buses, where, what, hint):
        with pytest.raises(UsageError) as caught:
            reader.read(name, PartEntry(kind="kind", buses=buses))
        assert where in str(caught.value)
        assert what in str(caught.value)
        assert hint in str(caught.value)


def test_a_bench_file_says_where_it_is_wrong(read):
    text = 'version = 1\n[targets.brain]\nboard = "bluepill"\nfirmware = "a.elf"\n[parts.s]\nkind = "distance-switch"\n'
    text += 'pins = { out = "brain.PA4" }\nsignals = { range = "world.ray_1" }\nbuses = { i2c = "brain.I2C1" }\n'
    with pytest.raises(UsageError, match=r"my\.toml:9: a distance-switch has no bus 'i2c'; it has none"):
        read(text)
