"""The wires of an SPI interface while it is a master: SCK and MOSI as a word goes out, and what is found on MISO.

Where nobody can react to an edge of SCK or MOSI, a word is one event at its end; edges that are recorded are told then,
or when somebody looks, and what no slave of the bus has said is the level of the pin at that end. Otherwise each edge
happens at its cycle and each bit is sampled from its pin, so that wires to other pins, to other boards or back to the
chip work.

A clock is two halves. MOSI changes with the first one; SCK leaves its idle level with the second, or with the first one
if CPHA is set; what comes in is sampled at the second (RM0008 figure 240).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from targets.mcu.services import InputSignal, OutputSignal, Services, Watch
from targets.mcu.spi_bus import SpiBus
from targets.mcu.timebase import Event

__all__ = ["SpiWire", "UnderWay", "Word"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Word:
    """What is to go over the wires.

    Attributes:
        bits: of MOSI, the first one as the highest.
        count: how many, 4 to 32.
        half_cycles: HCLK cycles of half a clock; a fraction where the clock of the words does not come from HCLK.
        cpha: CPHA.
        drives: MOSI is driven.
        one_wire: what comes in does so on MOSI.
    """

    bits: int
    count: int
    half_cycles: int | Fraction
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
        self._under_way: UnderWay | None = None
        for signal in (self._sck, self._mosi):
            signal.on_watch = self._watched

    @property
    def under_way(self) -> bool:
        """Whether a word is."""
        return self._under_way is not None

    def idle(self, cpol: bool) -> None:
        """Be a master that waits: SCK stands at its idle level, MOSI where it was, low at first (choice)."""
        self._cpol = cpol
        if not self.under_way:
            self._sck.set(cpol)
        if self._mosi_level is None:
            self._put_mosi(False)
        self._sck.refresh = self._mosi.refresh = self._tell

    def release(self) -> None:
        """Drive nothing; a word under way is broken off."""
        self._tell()
        if self._under_way is not None:
            self._time.cancel(self._under_way.event)
            self._under_way = None
        self._sck.refresh = self._mosi.refresh = None
        self._sck.set(None)
        self._mosi.set(None)
        self._mosi_level = None

    def send(self, word: Word, done: Callable[[int], None]) -> None:
        """Let a word go over the wires; `done` is called at its end with the bits that have come in."""
        if not word.drives and word.one_wire:
            self._mosi.set(None)
            self._mosi_level = None
        self._under_way = UnderWay(word, self._time.now, done)
        self._go_on()

    def _put_mosi(self, level: bool) -> None:
        self._mosi.set(level)
        self._mosi_level = level

    def _go_on(self) -> None:
        """Wait for the next half of a clock where somebody may react to it, else for the end of the word."""
        going = self._under_way
        assert going is not None
        if Watch.LIVE in (self._sck.watch(), self._mosi.watch()):
            self._half()
        else:
            going.event = self._time.at(going.cycle(going.halves), self._end)

    def _watched(self) -> None:
        """Somebody has begun or ended to look at the pins."""
        going = self._under_way
        if going is None:
            return
        self._tell()
        if self._under_way is not going:
            return
        self._time.cancel(going.event)
        live = Watch.LIVE in (self._sck.watch(), self._mosi.watch())
        if live:
            going.sample(self._level(going.word))
        next_half = going.told if live else going.halves
        going.event = self._time.at(max(going.cycle(next_half), self._time.now), self._half if live else self._end)

    # --- edge by edge

    def _half(self) -> None:
        going = self._under_way
        assert going is not None
        if going.told >= going.halves:
            self._end()
            return
        going.event = None
        self._tell()
        if self._under_way is not going or going.event is not None:  # broken off, or the pins are looked at otherwise
            return
        going.sample(self._level(going.word))
        following = self._half if Watch.LIVE in (self._sck.watch(), self._mosi.watch()) else self._end
        next_half = going.told if following == self._half else going.halves
        going.event = self._time.at(going.cycle(next_half), following)

    def _tell(self) -> None:
        """Bring levels and record of the pins up to the present cycle; who hears of it may break the word off."""
        going = self._under_way
        if going is None:
            return
        now = self._time.now
        while self._under_way is going and going.told < going.halves and going.cycle(going.told) <= now:
            self._tell_half(going)

    def _tell_half(self, going: UnderWay) -> None:
        word, half = going.word, going.told
        cycle = going.cycle(half)
        going.told += 1
        if not half & 1 and word.drives:
            _put(self._mosi, cycle, word.bit(half))
            if self._under_way is not going:
                return
            self._mosi_level = word.bit(half)
        _put(self._sck, cycle, self._sck_level(word, half))

    def _sck_level(self, word: Word, half: int) -> bool:
        return self._cpol is not (bool(half & 1) is not word.cpha)

    # --- its end

    def _end(self) -> None:
        going = self._under_way
        assert going is not None
        word = going.word
        self._to_end(word, looked=going.told > 0 or Watch.RECORD in (self._sck.watch(), self._mosi.watch()))
        going.told = going.halves
        going.sample(self._level(word))
        going.done(self._came_in(word, going.sampled))

    def _to_end(self, word: Word, *, looked: bool) -> None:
        """Bring the wires to the end of a word, with all its edges if somebody looks."""
        if looked:
            self._tell()
        elif word.drives:
            self._put_mosi(bool(word.bits & 1))
        self._under_way = None
        if self._sck.refresh is not None:
            self._sck.set(self._cpol)

    def _level(self, word: Word) -> bool:
        return (self._back if word.one_wire else self._miso).level()

    def _came_in(self, word: Word, at_pin: int) -> int:
        """Return the bits of the word that has ended: those of a slave, or what stood at the pin."""
        sent = word.bits if word.drives else (1 << word.count) - 1
        now_ns = self._time.ns(self._time.now)
        answer = self._bus.exchange(sent, word.count, self._cpol << 1 | word.cpha, now_ns)
        return at_pin if answer is None else answer


class UnderWay:
    """A word on the wires.

    Attributes:
        word: what it is.
        done: called at its end.
        halves: of clocks that it takes.
        told: so many of them the pins know of.
        sampled: the bits that stood at the pin, of those halves at which it was looked at.
        event: the next one.
    """

    __slots__ = ("_begin", "_looked", "done", "event", "halves", "sampled", "told", "word")

    def __init__(self, word: Word, begin: int, done: Callable[[int], None]) -> None:
        self.word = word
        self.done = done
        self.halves = 2 * word.count
        self.told = self.sampled = self._looked = 0
        self.event: Event | None = None
        self._begin = begin

    def sample(self, level: bool) -> None:
        """Take what stands at the pin for all bits that were not looked at yet, of the halves that were told."""
        bits = self.told // 2
        for _ in range(self._looked, bits):
            self.sampled = self.sampled << 1 | level
        self._looked = bits

    def resume(self, sampled: int, looked: int) -> None:
        """Go on behind so many bits that have come in."""
        self.sampled, self._looked = sampled, looked

    def cycle(self, half: int) -> int:
        """Return the cycle at which a half begins, or the first one after that."""
        return self._begin + math.ceil(half * self.word.half_cycles)


def _put(signal: OutputSignal, cycle: int, level: bool) -> None:
    if signal.watch() is Watch.RECORD:
        signal.set_at(cycle, level)
    else:
        signal.set(level)
