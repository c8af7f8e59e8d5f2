"""Clocks put out at pins: MCO (RM0008 section 7.2.10, RM0410 section 5.2.13, RM0433 section 8.5.5).

The output is high for half of its period (choice: the manuals say nothing of the duty behind an odd prescaler), begins
low when its clock is chosen or starts (choice: silicon may cut periods short then), and stays low while that clock
stands still (choice). Up to 100 kHz each edge is told, at the first cycle that does not fall before it. Above that
(choice: most are megahertz, and a host could not follow) there are no edges: the level stays low, and rate and duty are
told as `targets.mcu.services.Wave`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from targets.mcu.services import Services, Watch, Wave
from targets.mcu.timebase import Event

__all__ = ["FASTEST_EDGES_HZ", "FAST_CLOCKS", "Choice", "ClockOutput"]

FASTEST_EDGES_HZ = 100_000
"""The highest rate of which each edge is told."""
FAST_CLOCKS = "MCO: a clock above 100 kHz has a rate and a duty, but no edges"
_HALF = Fraction(1, 2)


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """The fields of RCC_CFGR that choose what an output carries.

    Attributes:
        name: of the signal.
        shift: lowest bit of the clock's field.
        clocks: for each value of it the name of a clock, or None for no output at all.
        prescaler: lowest bit of the prescaler's field.
        dividers: for each value of it the divider; 0 switches the output off.
    """

    name: str
    shift: int
    clocks: Sequence[str | None]
    prescaler: int = 0
    dividers: Sequence[int] = (1,)

    def rate(self, cfgr: int, clocks: Mapping[str, Fraction]) -> Fraction | None:
        """Return the rate of the output: 0 while its clock stands still, None where it drives nothing."""
        clock = self.clocks[cfgr >> self.shift & len(self.clocks) - 1]
        divider = self.dividers[cfgr >> self.prescaler & len(self.dividers) - 1]
        if clock is None:
            return None
        return clocks[clock] / divider if divider else Fraction(0)


class ClockOutput:
    """One output.

    Args:
        services: what the chip offers.
        choice: the fields that say what it carries.
    """

    def __init__(self, services: Services, choice: Choice) -> None:
        self._choice = choice
        self._time = services.time
        self._signal = services.output(choice.name)
        self._signal.on_watch = self._watched
        self._rate: Fraction | None = None
        self._half_s: Fraction | None = None  # while its edges are told
        self._start_s = Fraction(0)
        self._told = 0  # edges since then
        self._event: Event | None = None

    def follow(self, cfgr: int, clocks: Mapping[str, Fraction]) -> None:
        """Put out what a value of CFGR chooses, of clocks with these rates in hertz; 0 for one that stands still."""
        rate = self._choice.rate(cfgr, clocks)
        if rate == self._rate:
            return
        self.refresh()
        self._time.cancel(self._event)
        told = bool(rate) and rate is not None and rate <= FASTEST_EDGES_HZ
        self._rate, self._half_s = rate, None
        signal = self._signal
        signal.set(None if rate is None else False)
        signal.set_wave(Wave(hz=rate, duty=_HALF) if rate and not told else None)
        if told:
            assert rate is not None
            self._half_s, self._start_s, self._told = 1 / rate / 2, self._time.seconds(self._time.now), 0
        signal.refresh = self.refresh if told else None
        self._watched()

    def refresh(self) -> None:
        """Tell the edges up to the present cycle; before a change of HCLK too, for cycles are then counted anew."""
        half_s, signal = self._half_s, self._signal
        watch = signal.watch()
        if half_s is None or watch is Watch.LIVE:
            return
        time = self._time
        due = int((time.seconds(time.now) - self._start_s) / half_s)
        if watch is Watch.RECORD:
            for number in range(self._told + 1, due + 1):
                signal.set_at(time.cycle_at(self._start_s + number * half_s), bool(number & 1))
        elif due > self._told:
            signal.set_at(time.now, bool(due & 1))
        self._told = max(due, self._told)

    def _watched(self) -> None:
        """Tell each edge as it comes if something may react to it."""
        self._time.cancel(self._event)
        if self._half_s is not None and self._signal.watch() is Watch.LIVE:
            self._event = self._time.at_time(self._start_s + (self._told + 1) * self._half_s, self._edge)

    def _edge(self) -> None:
        self._told += 1
        self._signal.set(bool(self._told & 1))
        self._watched()
