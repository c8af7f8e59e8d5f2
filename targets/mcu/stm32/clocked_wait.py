"""Waits for a number of ticks of a clock whose rate may change meanwhile, or which may stand still."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from targets.mcu.timebase import Event, Timebase

__all__ = ["ClockedWait"]


class ClockedWait:
    """One such wait after the other, without an error that adds up: the next one may begin where the last has ended.

    Args:
        time: the chip's cycles and events.

    Attributes:
        pending: whether a wait is under way.
    """

    __slots__ = ("_action", "_cycles", "_end", "_event", "_left", "_time", "pending")

    def __init__(self, time: Timebase) -> None:
        self.pending = False
        self._time = time
        self._cycles = Fraction(0)  # of a tick; 0 stands still
        self._action: Callable[[], None] = lambda: None
        self._event: Event | None = None
        self._end = Fraction(0)  # in cycles, exactly
        self._left = Fraction(0)  # ticks, while the clock stands still

    def start(self, ticks: Fraction | int, action: Callable[[], None], *, follows: bool = False) -> None:
        """Wait for so many ticks in place of any wait under way.

        Args:
            ticks: how many.
            action: what happens then, at the first cycle not before.
            follows: begin exactly where the last wait has ended, in whose action this is called.
        """
        self.stop()
        self.pending = True
        self._action = action
        if not self._cycles:
            self._left = Fraction(ticks)
            return
        self._end = (self._end if follows else self._time.now) + ticks * self._cycles
        self._enter()

    def stop(self) -> None:
        """Wait no longer."""
        self._time.cancel(self._event)
        self.pending = False

    def set_rate(self, cycles: Fraction) -> None:
        """Let a tick take so many cycles from now on; 0 stands still."""
        if cycles == self._cycles:
            return
        if self.pending:
            if self._cycles:
                self._left = (self._end - self._time.now) / self._cycles
                self._time.cancel(self._event)
            if cycles:
                self._end = self._time.now + self._left * cycles
        self._cycles = cycles
        if self.pending and cycles:
            self._enter()

    def _enter(self) -> None:
        self._event = self._time.at(-(-self._end.numerator // self._end.denominator), self._over)

    def _over(self) -> None:
        self.pending = False
        self._action()
