"""An oscillator: switched on, it is ready some time later."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from targets.mcu.timebase import Event, Timebase

__all__ = ["Oscillator"]


class Oscillator:
    """An oscillator, or a PLL, with its start-up time.

    Args:
        time: the chip's time.
        start_s: seconds from switching on to ready.
        stop_s: seconds from switching off to not ready.
        on_ready: called with the new state when it becomes ready or ceases to be.

    Attributes:
        on: it is switched on.
        ready: it gives a clock.
        works: it can become ready; False where the board lacks the crystal.
    """

    def __init__(self, time: Timebase, start_s: Fraction, stop_s: Fraction, on_ready: Callable[[bool], None]) -> None:
        self.on = False
        self.ready = False
        self.works = True
        self._time = time
        self._start_s = start_s
        self._stop_s = stop_s
        self._on_ready = on_ready
        self._event: Event | None = None

    def switch(self, on: bool) -> None:
        """Switch it on or off; switching it to what it is has no effect."""
        if on is self.on:
            return
        self.on = on
        self._time.cancel(self._event)
        if on:
            self._become(False)
            self._start()
        elif self._stop_s:
            self._event = self._in(self._stop_s, False)
        else:
            self._become(False)

    def stop_now(self) -> None:
        """Switch it off without a delay: a reset, or the entry into a sleep mode."""
        self.on = False
        self._time.cancel(self._event)
        self._become(False)

    def run_now(self) -> None:
        """Switch it on without a delay: the clock a chip starts with."""
        self.on = True
        self._time.cancel(self._event)
        self._become(True)

    def fail(self) -> None:
        """The crystal breaks: no clock from now on, switched on or not."""
        self.works = False
        self._time.cancel(self._event)
        self._become(False)

    def repair(self) -> None:
        """The crystal works (again); if it is switched on, it starts."""
        self.works = True
        if self.on and not self.ready:
            self._start()

    def _start(self) -> None:
        if self.works:
            self._event = self._in(self._start_s, True)

    @property
    def ready_s(self) -> Fraction | None:
        """Bench time at which it will be ready; None if it is, or will not be."""
        event = self._event
        return event.time_s if event is not None and self.on and not self.ready and self.works else None

    def _in(self, seconds: Fraction, ready: bool) -> Event:
        time = self._time
        return time.at_time(time.seconds(time.now) + seconds, lambda: self._become(ready))

    def _become(self, ready: bool) -> None:
        if ready is not self.ready:
            self.ready = ready
            self._on_ready(ready)
