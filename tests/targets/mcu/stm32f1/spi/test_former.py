"""An SPI in C does to the cycle what it did in Python, whatever is written when, whoever looks or answers."""

from __future__ import annotations

import dataclasses
from functools import partial

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from targets.mcu.nets import Net
from targets.mcu.pins import PadMode, Pins
from targets.mcu.signals import Signals
from targets.mcu.stm32.spi_wire import SpiWire
from targets.mcu.stm32f1.spi import Spi
from targets.mcu.testing import FakeChip
from tests.share import examples
from tests.targets.mcu.stm32.spi.slave import Promising, Slave
from tests.targets.mcu.stm32f1.spi.former import Spi as Former

CR1, CR2, SR, DR, CRCPR, RXCRCR, TXCRCR, I2SCFGR = range(0, 0x20, 4)
DFF, CRCNEXT, CRCEN, BIDIOE, BIDIMODE = 1 << 11, 1 << 12, 1 << 13, 1 << 14, 1 << 15
MSTR, SPE, SSI, SSM = 1 << 2, 1 << 6, 1 << 8, 1 << 9
MASTER = MSTR | SPE | SSI | SSM
PINS = ("PA4", "PA5", "PA6", "PA7", "PB3", "PB4", "PB5", "PA15")
USUAL = {"SPI1_NSS": "PA4", "SPI1_SCK": "PA5", "SPI1_MISO": "PA6", "SPI1_MOSI": "PA7", "TIM3_CH2": "PA7"}
MOVED = {"SPI1_NSS": "PA15", "SPI1_SCK": "PB3", "SPI1_MISO": "PB4", "SPI1_MOSI": "PB5", "TIM3_CH2": "PB5"}
ALTERNATE = PadMode.AF_PUSH_PULL
LEVELS = st.sampled_from((None, False, True))

MODES = st.sampled_from((0, 1, 2, 3, 1 << 7, 1 << 10, DFF, CRCEN, CRCEN | DFF, BIDIMODE, BIDIMODE | BIDIOE))
PROGRAM = st.one_of(
    st.tuples(st.just("write"), st.sampled_from((CR1, CR2, SR, DR, CRCPR, RXCRCR)), st.integers(0, 0xFFFF)),
    st.tuples(st.just("write"), st.just(CR2), st.sampled_from((0, 3, 0x23, 0xE3, 0xE0, 4))),
    st.tuples(st.just("write"), st.just(I2SCFGR), st.sampled_from((0, 0, 1 << 11))),
    st.tuples(st.just("master"), MODES, MODES, st.integers(0, 2)),
    st.tuples(st.just("crcnext")),
    st.tuples(st.just("send"), st.integers(0, 0xFFFF)),
    st.tuples(st.just("send"), st.integers(0, 0xFFFF)),
    st.tuples(st.just("read"), st.sampled_from((SR, SR, DR, DR, DR, CR1))),
    st.tuples(st.just("reset")),
)
AROUND = st.one_of(
    st.tuples(st.just("wait"), st.integers(1, 200)),
    st.tuples(st.just("wait"), st.sampled_from((16, 32))),
    st.tuples(st.just("pclk"), st.sampled_from((1, 1, 2, 4))),
    st.tuples(st.just("hclk"), st.sampled_from((8, 36, 72))),
    st.tuples(st.just("select"), st.integers(0, 1)),
    st.tuples(st.just("clocked"), st.integers(0, 0xFFFF)),
    st.tuples(st.just("left"), st.integers(0, 1)),
    st.tuples(st.just("dma"), st.booleans()),
    st.tuples(st.just("told")),
)
OUTSIDE = st.one_of(
    st.tuples(st.just("look"), st.sampled_from(PINS)),
    st.tuples(st.just("look"), st.sampled_from(PINS)),
    st.tuples(st.just("drive"), st.sampled_from(PINS), LEVELS, st.sampled_from((50.0, 10_000.0))),
    st.tuples(st.just("ramp"), st.sampled_from(PINS)),
    st.tuples(st.just("mode"), st.sampled_from(PINS), st.sampled_from(PadMode), LEVELS),
    st.tuples(st.just("record"), st.sampled_from(PINS), st.booleans()),
    st.tuples(st.just("hear"), st.sampled_from(PINS)),
    st.tuples(st.just("deaf"), st.sampled_from(PINS)),
    st.tuples(st.just("other_drives"), LEVELS),
    st.tuples(st.just("route"), st.sampled_from((USUAL, MOVED))),
    st.tuples(st.just("loop")),
)


class Rig:
    """An interface at pins."""

    def __init__(self, kind, slaves, *, promising):
        self.chip = FakeChip(72_000_000)
        self.pins = Pins(PINS, self.chip.time, self.chip.notes)
        self.signals = Signals(self.pins)
        services = dataclasses.replace(self.chip.services, output=self.signals.output, input=self.signals.input)
        self.to_come, self.edges, self.hearers = 1, [], {}
        more = {"bus": "APB2", "irq": 35, "has_i2s": True, "tx_left": lambda: self.to_come}
        self.spi = self.chip.add(kind("SPI1", 0x4001_3000, services, **more))
        self.other = self.signals.output("TIM3_CH2")
        self.route(USUAL)
        for pin in PINS:
            usual = ALTERNATE if pin in ("PA5", "PA7", "PB3", "PB5") else PadMode.INPUT
            self.pins[pin].configure(usual, latch=False, pull=None)
        kinds = (Slave, Promising if promising else Slave)
        self.slaves = [kinds[promises](*range(3, 255, 7), modes=modes) for modes, promises in slaves]
        for slave in self.slaves:
            self.spi.bus.attach(slave)
        self.requests = [self.chip.dma(f"SPI1_{name}") for name in ("TX", "RX")]
        self.moved = []

    def route(self, where):
        for name, pin in where.items():
            self.signals.route(name, pin)

    def act(self, what, *more):
        return getattr(self, what)(*more)

    def write(self, offset, value):
        self.spi.write(offset, value)

    def read(self, offset):
        return self.spi.read(offset)

    def master(self, mode, more, br):
        self.spi.write(CR1, (MASTER | mode | more | br << 3) & ~SPE)
        self.spi.write(CR1, MASTER | mode | more | br << 3)

    def crcnext(self):
        self.spi.write(CR1, self.spi[CR1] | CRCNEXT)

    def send(self, word):
        self.spi.write(DR, word)

    def reset(self):
        self.spi.reset()

    def wait(self, cycles):
        self.chip.advance(cycles)

    def pclk(self, divider):
        self.chip.change_clock(APB2=divider)

    def hclk(self, mhz):
        self.chip.change_clock(mhz * 1_000_000)

    def select(self, number):
        if number < len(self.slaves):
            self.slaves[number].select(not self.slaves[number].on)

    def clocked(self, bits):
        return self.spi.exchange(bits & (0xFFFF if self.spi[CR1] & DFF else 0xFF))

    def left(self, count):
        self.to_come = count

    def dma(self, on):
        """Have a controller serve requests, each after five cycles."""
        for request, move in zip(self.requests, (self._send_next, self._take), strict=True):
            request.on_set = partial(self._asked, request, move) if on else lambda _level: None

    def _asked(self, request, move, level):
        if level:
            self.chip.time.after(5, lambda: move() if request.level else None)

    def _send_next(self):
        if len(self.moved) < 400:
            self.spi.write(DR, 37 * len(self.moved) & 0xFFFF)
        self.moved.append(None)

    def _take(self):
        self.moved.append(self.spi.read(DR))

    def look(self, pin):
        return self.pins[pin].level, self.pins[pin].reads_high

    def drive(self, pin, level, ohms):
        self.pins[pin].drive(level, ohms=ohms)

    def ramp(self, pin):
        self.pins[pin].drive_ramp(0.0, 3.3, in_ns=3000)

    def mode(self, pin, mode, pull):
        self.pins[pin].configure(mode, latch=True, pull=pull)

    def record(self, pin, on):
        self.pins[pin].record(on)

    def hear(self, pin):
        if pin not in self.hearers:
            self.hearers[pin] = lambda *edge: self.edges.append((pin, *edge))
            self.pins[pin].on_edge(self.hearers[pin])

    def deaf(self, pin):
        if pin in self.hearers:
            self.pins[pin].off_edge(self.hearers.pop(pin))

    def other_drives(self, level):
        self.other.set(level)

    def loop(self):
        if not self.pins["PA6"].nets:
            Net("loop", (self.pins["PA6"], self.pins["PA7"]), None)

    def told(self):
        """Return what slaves have heard."""
        self.spi.bus.settle()
        return [slave.bytes for slave in self.slaves]

    def state(self):
        pins = {pin.name: (list(pin.edges), pin.level) for pin in self.pins if pin.recording}
        return {
            "registers": {offset: self.spi[offset] for offset in self.spi.registers},
            "irq": self.chip.irq(35).changes,
            "requests": [request.changes for request in self.requests],
            "moved": self.moved,
            "notes": self.chip.notes.all,
            "heard": self.edges,
            "recorded": pins,
        }


@given(
    actions=st.lists(PROGRAM | PROGRAM | AROUND | OUTSIDE, min_size=10, max_size=60),
    slaves=st.lists(st.tuples(st.sampled_from(((0, 3), (1, 2))), st.booleans()), max_size=2),
    looped=st.booleans(),
)
@example(actions=[("send", 0), ("wait", 16), ("other_drives", False)], slaves=[], looped=True)
@settings(max_examples=examples(125))
def test_any_program(actions, slaves, looped):
    rigs = [Rig(Spi, slaves, promising=True), Rig(Former, slaves, promising=False)]
    for action in (*[("loop",)] * looped, ("master", 0, 0, 0), ("send", 0x35), *actions, ("wait", 5000), ("told",)):
        answers = [rig.act(*action) for rig in rigs]
        assert answers[0] == answers[1], action
        states = [rig.state() for rig in rigs]
        for name, value in states[1].items():
            assert states[0][name] == value, (action, name)
    for pin in PINS:
        assert rigs[0].look(pin) == rigs[1].look(pin), pin


def test_a_level_that_was_told_of_late_is_right():
    rig = Rig(Spi, [], promising=True)
    rig.master(0, 0, 0)
    for word in (1, 2, 3, 5):
        rig.send(word)
        rig.wait(16)
    assert rig.look("PA7") == (True, True)


@pytest.mark.parametrize("kind", [Spi, Former])
@pytest.mark.parametrize(("pin", "edge"), [("PA5", 1), ("PA5", 4), ("PA7", 1), ("PA7", 4)])
@pytest.mark.parametrize("looped", [False, True])
def test_whoever_sees_an_edge_may_take_the_bus(kind, pin, edge, looped):
    """A mode fault breaks the word off, and the pins are let go, at that very edge."""
    rig, seen = Rig(kind, [], promising=True), []

    def take_the_bus(*_edge):
        seen.append(rig.chip.time.now)
        if len(seen) == edge:
            rig.drive("PA4", False, 50.0)

    if looped:
        rig.loop()
    rig.drive("PA4", True, 10_000.0)
    rig.write(CR1, MSTR | SPE | 1)
    rig.send(0x55)
    rig.wait(20)
    rig.read(DR)
    rig.send(0xAA)
    rig.wait(2 * looped)
    rig.pins[pin].on_edge(take_the_bus)
    rig.wait(100)
    assert seen[edge - 1] == seen[-1], "the pins were driven again"
    assert (rig.spi[CR1] & (MSTR | SPE), rig.read(SR)) == (0, 0x22)
    assert (rig.look("PA5")[0], rig.look("PA7")[0]) == (None, None)


@pytest.mark.parametrize("kind", [Spi, Former])
@pytest.mark.parametrize(("pin", "edge"), [("PA5", 1), ("PA5", 4), ("PA7", 1), ("PA7", 4)])
@pytest.mark.parametrize("looped", [False, True])
def test_whoever_sees_an_edge_may_look_no_more(kind, pin, edge, looped):
    rig, seen = Rig(kind, [], promising=True), []

    def look_no_more(*_edge):
        seen.append(rig.chip.time.now)
        if len(seen) == edge:
            rig.pins[pin].off_edge(look_no_more)

    if looped:
        rig.loop()
    rig.master(0, 0, 0)
    rig.send(0x55)
    rig.wait(2)
    rig.pins[pin].on_edge(look_no_more)
    rig.wait(13)
    assert (rig.read(SR), len(seen)) == (0x82, edge)
    rig.wait(1)
    assert (rig.read(SR), rig.read(DR)) == (3, 0x55 if looped else 0)
    rig.wait(100)
    assert rig.read(SR) == 2


def test_a_wire_back_needs_nobody_who_looks(monkeypatch):
    """Words go round in C, until somebody looks in the middle of one."""
    rig, told = Rig(Spi, [], promising=True), []
    monkeypatch.setattr(SpiWire, "_tell_half", lambda *_more: told.append(rig.chip.time.now))
    rig.loop()
    rig.master(0, DFF, 0)
    for word in (0xA5C3, 0x0001, 0x8000):
        rig.send(word)
        rig.wait(32)
        assert rig.read(DR) == word
    assert not told
    monkeypatch.undo()
    rig.send(0x0F0F)
    rig.wait(9)  # the second half of the fifth bit
    assert [rig.look(pin)[1] for pin in ("PA5", "PA6", "PA7")] == [True] * 3
    rig.wait(23)
    assert rig.read(DR) == 0x0F0F
