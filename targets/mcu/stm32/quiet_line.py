"""Waits until a serial line has been high for so many bits, unless a start bit comes first."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from targets.mcu.stm32.bit_clock import BitClock
from targets.mcu.timebase import Event, Timebase

__all__ = ["QuietLine"]


class QuietLine:
    """One such wait after the other.

    Args:
        time: the chip's cycles and events.
        action: called when the line was quiet for long enough.
    """

    __slots__ = ("_action", "_clock", "_end", "_event", "_last_cycle", "_time")

    def __init__(self, time: Timebase, action: Callable[[], None]) -> None:
        self._time = time
        self._action = action
        self._clock = BitClock()
        self._end = 0
        self._last_cycle = 0
        self._event: Event | None = None

    def start(self, cycle: int, sixteenths: int, bit_cycles: int | Fraction) -> None:
        """Wait for so many sixteenths of a bit from `cycle` on, in place of any wait under way."""
        self._clock.start(cycle, bit_cycles)
        self._end = sixteenths
        self._enter()

    def stop(self) -> None:
        """Wait no longer."""
        self._time.cancel(self._event)
        self._event = None

    def broken_at(self, cycle: int) -> None:
        """A start bit begins at `cycle`: if the wait is not over by then, it is in vain."""
        if self._event is not None and cycle <= self._last_cycle:
            self.stop()

    def set_rate(self, bit_cycles: int | Fraction) -> None:
        """Let a bit take so many cycles from now on."""
        if self._event is not None:
            self._clock.change(self._time.now, bit_cycles)
            self._enter()

    def _enter(self) -> None:
        self._time.cancel(self._event)
        self._last_cycle = self._clock.cycle(self._end)
        self._event = self._time.at(self._last_cycle, self._over)

    def _over(self) -> None:
        self._event = None
        self._action()
