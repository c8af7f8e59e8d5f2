"""Something that a check's peer says again and again by itself, at a steady rate, until it is told to stop."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from hilbench.bench import Bench
from hilbench.clock import ClockDomain, Entry, EventClass

__all__ = ["Feed"]


class Feed:
    """Calls an action at a steady rate.

    Args:
        bench: whose time is used.
        say: what is done each time.
        name: who does it, for the order of what happens at one instant.

    Attributes:
        said: how often it was done, in all.
        last_ns: bench time at which it was done last; None if it never was.
    """

    def __init__(self, bench: Bench, say: Callable[[], None], *, name: str) -> None:
        self._bench = bench
        self._say = say
        self._name = name
        self._entry: Entry | None = None
        self.said = 0
        self.last_ns: int | None = None

    @property
    def running(self) -> bool:
        """Whether it goes on."""
        return self._entry is not None

    def start(self, rate_hz: float, *, first_after_s: float = 0.0) -> None:
        """Begin, or begin anew, at a rate; no rounding error adds up."""
        self.stop()
        self._clock = ClockDomain(Fraction(rate_hz))
        self._epoch_ns = self._bench.now_ns + round(first_after_s * 1e9)
        self._tick = 0
        self._book()

    def stop(self) -> None:
        """Stop; a second call does nothing."""
        if self._entry is not None:
            self._bench.scheduler.cancel(self._entry)
            self._entry = None

    def _book(self) -> None:
        when_ns = self._epoch_ns + self._clock.ns(self._tick)
        self._entry = self._bench.scheduler.at(
            max(when_ns, self._bench.now_ns), self._due, order=EventClass.TIMER, source=self._name
        )

    def _due(self) -> None:
        self._tick += 1
        self.said += 1
        self.last_ns = self._bench.now_ns
        self._book()
        self._say()
