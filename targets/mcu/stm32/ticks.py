"""Ticks of a clock that need not know anything of HCLK, and what falls due at one of them."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from targets.mcu.timebase import Event, Timebase

__all__ = ["Edges", "Ticks"]


class Ticks:
    """The ticks of a clock with a rate, counted from bench time.

    A tick that is under way when the rate changes keeps the part of it that has gone; one that is under way when the
    clock stops is lost.

    Args:
        time: the chip's time.
        hz: returns the present rate, 0 or None while the clock stands still; `refresh` is to be called when it changes.
    """

    def __init__(self, time: Timebase, hz: Callable[[], Fraction | None]) -> None:
        self._time = time
        self._ask_hz = hz
        self._hz: Fraction | None = None
        self._tick = 0  # at bench time `_since_s`
        self._since_s = Fraction(0)
        self._due: dict[str, tuple[int, Callable[[], None]]] = {}
        self._events: dict[str, Event] = {}

    @property
    def runs(self) -> bool:
        """Whether the clock runs."""
        return self._hz is not None

    def now(self) -> int:
        """Return the ticks so far."""
        if self._hz is None:
            return self._tick
        return self._tick + int((self._now_s() - self._since_s) * self._hz)

    def refresh(self) -> None:
        """Take the present rate of the clock."""
        hz = self._ask_hz() or None
        if hz == self._hz:
            return
        now_s, gone = self._now_s(), Fraction(0)
        if self._hz is not None:
            gone = (now_s - self._since_s) * self._hz
            self._tick, gone = self._tick + int(gone), gone % 1
        self._hz = hz
        self._since_s = now_s - gone / hz if hz is not None else now_s
        for name, (tick, action) in list(self._due.items()):
            self.at(name, tick, action)

    def at(self, name: str, tick: int, action: Callable[[], None]) -> None:
        """Have something happen at a tick, in place of what has this name."""
        self.forget(name)
        self._due[name] = tick, action
        if self._hz is None:
            return

        def happen() -> None:
            del self._due[name], self._events[name]
            action()

        self._events[name] = self._time.at_time(self._since_s + (tick - self._tick) / self._hz, happen)

    def after(self, name: str, ticks: int, action: Callable[[], None]) -> None:
        """Have something happen so many ticks from now."""
        self.at(name, self.now() + ticks, action)

    def due(self, name: str) -> bool:
        """Say whether what has this name is still to happen."""
        return name in self._due

    def forget(self, name: str) -> None:
        """Let what has this name not happen."""
        self._due.pop(name, None)
        self._time.cancel(self._events.pop(name, None))

    def forget_all(self) -> None:
        """Let nothing happen."""
        for name in list(self._due):
            self.forget(name)

    def _now_s(self) -> Fraction:
        return self._time.seconds(self._time.now)


class Edges:
    """A clock whose ticks somebody makes, as edges at a pin do; otherwise as `Ticks`."""

    runs = True

    def __init__(self) -> None:
        self._tick = 0
        self._due: dict[str, tuple[int, Callable[[], None]]] = {}

    def now(self) -> int:
        """Return the ticks so far."""
        return self._tick

    def step(self) -> None:
        """Make a tick; what is due happens, in the order of ticks and then of asking."""
        self._tick += 1
        while due := [(tick, name) for name, (tick, _) in self._due.items() if tick <= self._tick]:
            _, action = self._due.pop(min(due, key=lambda entry: entry[0])[1])
            action()

    def at(self, name: str, tick: int, action: Callable[[], None]) -> None:
        """Have something happen at a tick, in place of what has this name."""
        self._due.pop(name, None)
        self._due[name] = tick, action

    def after(self, name: str, ticks: int, action: Callable[[], None]) -> None:
        """Have something happen so many ticks from now."""
        self.at(name, self._tick + ticks, action)

    def due(self, name: str) -> bool:
        """Say whether what has this name is still to happen."""
        return name in self._due

    def forget(self, name: str) -> None:
        """Let what has this name not happen."""
        self._due.pop(name, None)

    def forget_all(self) -> None:
        """Let nothing happen."""
        self._due.clear()
