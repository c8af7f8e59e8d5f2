"""The wires of an SPI interface while it is a master: SCK and MOSI as a word goes out, and what is found on MISO.

Where nobody can react to an edge of SCK or MOSI, a word is one event at its end; edges that are recorded are told then,
and what no slave of the bus has said is the level of the pin at that moment. Otherwise each edge happens at its cycle
and each bit is sampled from its pin, so that wires to other pins, to other boards or back to the chip work.

A clock is two halves. MOSI changes with the first one; SCK leaves its idle level with the second, or with the first one
if CPHA is set; what comes in is sampled at the second (RM0008 figure 240).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from targets.mcu.services import InputSignal, OutputSignal, Services, Watch
from targets.mcu.spi_bus import SpiBus

__all__ = ["SpiWire", "Word"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Word:
    """What is to go over the wires.

    Attributes:
        bits: of MOSI, the first one as the highest.
        count: how many, 8 or 16.
        half_cycles: HCLK cycles of half a clock.
        cpha: CPHA.
        drives: MOSI is driven.
        one_wire: what comes in does so on MOSI.
    """

    bits: int
    count: int
    half_cycles: int
    cpha: bool
    drives: bool
    one_wire: bool

    def bit(self, half: int) -> bool:
        """Return the bit of MOSI in a half of a clock, counted from 0."""
        return bool(self.bits >> self.count - 1 - half // 2 & 1)


class SpiWire:
    """See the module.

    Args:
        name: ``SPI1``.
        services: what the chip offers. Used: the signals ``SPI1_SCK``, ``SPI1_MOSI``, ``SPI1_MISO``.
        bus: the slaves.
    """

    def __init__(self, name: str, services: Services, bus: SpiBus) -> None:
        self._time = services.time
        self._sck: OutputSignal = services.output(f"{name}_SCK")
        self._mosi: OutputSignal = services.output(f"{name}_MOSI")
        self._miso: InputSignal = services.input(f"{name}_MISO")
        self._back: InputSignal = services.input(f"{name}_MOSI")
        self._bus = bus
        self._cpol = False
        self._mosi_level: bool | None = None

    def idle(self, cpol: bool) -> None:
        """Be a master that waits: SCK stands at its idle level, MOSI where it was, low at first (choice)."""
        self._cpol = cpol
        self._sck.set(cpol)
        if self._mosi_level is None:
            self._mosi.set(False)
            self._mosi_level = False

    def release(self) -> None:
        """Drive nothing."""
        self._sck.set(None)
        self._mosi.set(None)
        self._mosi_level = None

    def send(self, word: Word, done: Callable[[int], None]) -> None:
        """Let a word go over the wires; `done` is called at its end with the bits that have come in."""
        if not word.drives and word.one_wire:
            self._mosi.set(None)
            self._mosi_level = None
        if Watch.LIVE in (self._sck.watch(), self._mosi.watch()):
            self._half(word, 0, 0, done)
        else:
            begin = self._time.now
            self._time.after(2 * word.count * word.half_cycles, lambda: self._at_once(word, begin, done))

    # --- edge by edge

    def _half(self, word: Word, half: int, sampled: int, done: Callable[[int], None]) -> None:
        if half == 2 * word.count:
            self._sck.set(self._cpol)
            done(self._came_in(word, sampled))
            return
        if not half & 1 and word.drives:
            self._mosi.set(word.bit(half))
            self._mosi_level = word.bit(half)
        self._sck.set(self._sck_level(word, half))
        if half & 1:
            sampled = sampled << 1 | (self._back if word.one_wire else self._miso).level()
        self._time.after(word.half_cycles, lambda: self._half(word, half + 1, sampled, done))

    def _sck_level(self, word: Word, half: int) -> bool:
        return self._cpol is not (bool(half & 1) is not word.cpha)

    # --- at once

    def _at_once(self, word: Word, begin: int, done: Callable[[int], None]) -> None:
        if Watch.RECORD in (self._sck.watch(), self._mosi.watch()):
            self._record(word, begin)
        elif word.drives:
            self._mosi.set(bool(word.bits & 1))
        if word.drives:
            self._mosi_level = bool(word.bits & 1)
        level = (self._back if word.one_wire else self._miso).level()
        done(self._came_in(word, (1 << word.count) - 1 if level else 0))

    def _record(self, word: Word, begin: int) -> None:
        for half in range(2 * word.count):
            cycle = begin + half * word.half_cycles
            if not half & 1 and word.drives:
                _tell(self._mosi, cycle, word.bit(half))
            _tell(self._sck, cycle, self._sck_level(word, half))
        self._sck.set(self._cpol)

    def _came_in(self, word: Word, at_pin: int) -> int:
        """Return the bits of the word that has ended: those of a slave, or what stood at the pin."""
        sent = word.bits if word.drives else (1 << word.count) - 1
        now_ns = self._time.ns(self._time.now)
        answer = self._bus.exchange(sent, word.count, self._cpol << 1 | word.cpha, now_ns)
        return at_pin if answer is None else answer


def _tell(signal: OutputSignal, cycle: int, level: bool) -> None:
    if signal.watch() is Watch.RECORD:
        signal.set_at(cycle, level)
