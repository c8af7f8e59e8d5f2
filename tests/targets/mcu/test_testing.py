"""The chip in a test tube, with a peripheral as a user of it might write one."""

from __future__ import annotations

from fractions import Fraction

import pytest

from targets.mcu.errors import BusFault
from targets.mcu.registers import Peripheral, Register
from targets.mcu.testing import FakeChip, peek, poke


class Alarm(Peripheral):
    """Counts PCLK1 down from LOAD; at 0 it interrupts, asks for DMA, and drives a pin unless its input is high."""

    REGISTERS = (Register("LOAD", 0x00, 0, 0xFFFF), Register("SR", 0x04, 0, 1))

    def write_LOAD(self, value):
        self[0] = value
        self.time.after(value * self.services.clocks.pclk("APB1"), self._ring)

    def write_SR(self, value):
        self[4] = value
        self.services.irq(7).set(bool(value))

    def _ring(self):
        self[4] = 1
        self.services.irq(7).set(True)
        self.services.dma("ALARM").set(True)
        self.services.output("BELL").set(self.services.input("MUTE").level() is False)
        if self[0] == 13:
            self.services.chip_reset("WWDG")


@pytest.fixture
def chip():
    return FakeChip(hclk_hz=72_000_000, dividers={"APB1": 2})


@pytest.fixture
def alarm(chip):
    return chip.add(Alarm("ALARM", 0x4000_0000, chip.services))


def test_events_happen_at_their_own_cycles(chip, alarm):
    poke(alarm, "LOAD", 50)
    chip.advance(99)
    assert peek(alarm, "SR") == 0
    chip.advance(1000)
    assert peek(alarm, "SR") == 1
    assert chip.time.now == 1099
    assert chip.irq(7).rises == [100]
    assert chip.dma("ALARM").changes == [(100, True)]
    assert chip.output("BELL").edges == [(100, True)]
    poke(alarm, "SR", 0)
    assert chip.irq(7).changes == [(100, True), (1099, False)]


def test_inputs_are_driven(chip, alarm):
    seen = []
    chip.input("MUTE").on_change = seen.append
    chip.input("MUTE").drive(True)
    chip.input("MUTE").drive(True)
    poke(alarm, "LOAD", 1)
    chip.advance(2)
    assert seen == [True]
    assert chip.output("BELL").level is False


def test_resets_and_notes_are_kept(chip, alarm):
    poke(alarm, "LOAD", 13)
    chip.advance(26)
    alarm.read(0x10)
    assert chip.resets == ["WWDG"]
    assert chip.noted() == chip.noted("reserved") == ["ALARM_0x10"]
    assert chip.noted("misuse") == []


def test_advancing_by_seconds_follows_the_clock(chip):
    chip.time.at(36_000, lambda: chip.change_clock(8_000_000))
    chip.advance_s(Fraction(1, 1000))
    assert chip.time.now == 36_000 + 4_000


def test_a_change_of_the_clock_is_told(chip, alarm):
    calls = []
    alarm.before_clock_change = lambda: calls.append(("before", chip.clocks.pclk("APB1"), chip.time.hclk_hz))
    alarm.after_clock_change = lambda: calls.append(("after", chip.clocks.pclk("APB1"), chip.time.hclk_hz))
    chip.change_clock(8_000_000, APB1=4)
    assert calls == [("before", 2, 72_000_000), ("after", 4, 8_000_000)]
    assert [chip.clocks.timer(bus) for bus in ("AHB", "APB1", "APB2")] == [1, 2, 1]


def test_the_bus_has_memory_and_peripherals(chip, alarm):
    bus = chip.bus
    bus.load(0x2000_0000, b"\x01\x02\x03\x04")
    assert bus.read(0x2000_0000, 4) == 0x0403_0201
    bus.write(0x2000_0002, 2, 0xABCD)
    assert bus.dump(0x2000_0000, 4) == b"\x01\x02\xcd\xab"
    bus.write(0x4000_0000, 1, 0x12)  # replicated, as over APB
    assert bus.read(0x4000_0000, 4) == 0x1212
    assert bus.read(0x4000_0001, 1) == 0x12
    assert bus.accesses[-2:] == [("read", 0x4000_0000, 4, 0x1212), ("read", 0x4000_0001, 1, 0x12)]
    for size in (1, 2, 4):
        with pytest.raises(BusFault):
            bus.read(0x2000_0004, size)
        with pytest.raises(BusFault):
            bus.write(0x2000_0004, size, 0)


def test_registers_are_named(alarm):
    with pytest.raises(KeyError):
        peek(alarm, "CR1")
