"""The terminals of parts at the pins of chips.

A chip runs ahead of bench time until somebody acts, so what a terminal is asked for is answered from the edges that the
pin has had, by their bench time, and what it drives is put into the chip at the first cycle not before its time.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import partial

from hilbench.bench import Bench
from hilbench.mcu.seams import Machine
from targets.mcu.pins import Pin
from targets.parts.part import HISTORY_NS

__all__ = ["AnalogPinOutput", "PinInput", "PinOutput"]


class PinInput:
    """A wire that comes into a part from the pin of a chip; a pin that floats reads low.

    Args:
        bench: whose time it is asked in.
        pin: the pin.
    """

    def __init__(self, bench: Bench, pin: Pin) -> None:
        self._bench = bench
        self._pin = pin
        self._before = pin.level is True
        self._edges: deque[tuple[int, bool]] = deque()
        self._before_change: list[Callable[[], None]] = []
        pin.on_edge(self._changed)

    def level(self) -> bool:
        """Return the level now."""
        return self.level_at(self._bench.now_ns)

    def level_at(self, ns: int) -> bool:
        """Return the level at `ns`; at an edge the new one."""
        for at_ns, level in reversed(self._edges):
            if at_ns <= ns:
                return level
        return self._before

    def mean(self, from_ns: int, to_ns: int) -> float:
        """Return the part of that time in which the level was high, 0 to 1."""
        if to_ns <= from_ns:
            return float(self.level_at(to_ns))
        high_ns, since_ns, level = 0, from_ns, self.level_at(from_ns)
        for at_ns, changed in self._edges:
            if from_ns < at_ns < to_ns:
                high_ns += (at_ns - since_ns) * level
                since_ns, level = at_ns, changed
        return (high_ns + (to_ns - since_ns) * level) / (to_ns - from_ns)

    def changes(self, from_ns: int, to_ns: int) -> list[tuple[int, bool]]:
        """Return the changes after `from_ns` and up to `to_ns`, in order."""
        found: list[tuple[int, bool]] = []
        for at_ns, level in reversed(self._edges):
            if at_ns <= from_ns:
                break
            if at_ns <= to_ns:
                found.append((at_ns, level))
        return found[::-1]

    def latch(self) -> bool:
        """Return what the chip's output latch holds, whatever the direction of the pin."""
        return self._pin.latch

    def before_change(self, callback: Callable[[], None]) -> None:
        """Have `callback` called before each change of the level, of which nothing is known then."""
        self._before_change.append(callback)

    def _changed(self, _cycle: int, ns: int, level: bool | None) -> None:
        for callback in self._before_change:
            callback()
        self._edges.append((ns, level is True))
        oldest_ns = self._bench.now_ns - HISTORY_NS
        while self._edges[0][0] < oldest_ns:
            self._before = self._edges.popleft()[1]


class PinOutput:
    """A wire that a part drives, at the pin of a chip.

    Args:
        machine: the chip.
        pin: the pin.
    """

    def __init__(self, machine: Machine, pin: Pin) -> None:
        self._machine = machine
        self._pin = pin
        self._level: bool | None = None

    def set(self, level: bool | None, at_ns: int) -> None:
        """Drive the wire from `at_ns` on, or let it go (None)."""
        if level is not self._level:
            self._level = level
            self._machine.at_ns(at_ns, partial(self._pin.drive, level))


class AnalogPinOutput:
    """A wire on which a part puts a voltage, at the pin of a chip.

    Args:
        bench: whose time it is asked in.
        machine: the chip.
        pin: the pin.
    """

    def __init__(self, bench: Bench, machine: Machine, pin: Pin) -> None:
        self._bench = bench
        self._machine = machine
        self._pin = pin
        self._put: deque[tuple[int, float]] = deque()

    def put(self, volts: float, at_ns: int) -> None:
        """Put a voltage on the wire from `at_ns` on."""
        if not self._put or volts != self._put[-1][1]:
            self._forget()
            self._put.append((at_ns, volts))
            self._machine.at_ns(at_ns, partial(self._pin.drive_volts, volts))

    @property
    def volts(self) -> float | None:
        """What the part puts on the wire now; None before it has. The chip, which may be ahead, is not asked."""
        self._forget()
        return self._put[0][1] if self._put and self._put[0][0] <= self._bench.now_ns else None

    def _forget(self) -> None:
        while len(self._put) > 1 and self._put[1][0] <= self._bench.now_ns:
            self._put.popleft()
