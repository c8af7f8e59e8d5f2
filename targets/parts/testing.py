"""Doubles for tests of parts: wires with a memory, and a little bench that calls a part as `part.py` says."""

from __future__ import annotations

import itertools
from bisect import bisect_right
from collections.abc import Callable, Mapping

from targets.parts.part import Direction, Part, Ports

__all__ = ["PartBench", "Wire"]


class Wire:
    """A wire that remembers every edge: a `DigitalOutput` for who drives it, a `DigitalInput` for who reads it.

    Attributes:
        edges: (ns, level) of every call of `set`, in order; None is not driven.
        volts: (ns, volts) of every call of `put`, as above.
        latched: what `latch` says; None for the same as `level`.
        now_ns: the present; `level` is that of then.
    """

    def __init__(self) -> None:
        self.edges: list[tuple[int, bool | None]] = []
        self.volts: list[tuple[int, float]] = []
        self.latched: bool | None = None
        self.now_ns = 0
        self._before_change: list[Callable[[], None]] = []

    def set(self, level: bool | None, at_ns: int) -> None:
        """Drive the wire; time must not go back."""
        assert not self.edges or at_ns >= self.edges[-1][0], "an output went back in time"
        for callback in self._before_change:
            callback()
        self.edges.append((at_ns, level))

    def put(self, volts: float, at_ns: int) -> None:
        """Put a voltage on the wire; time must not go back."""
        assert not self.volts or at_ns >= self.volts[-1][0], "an output went back in time"
        self.volts.append((at_ns, volts))

    def driven_at(self, ns: int) -> bool | None:
        """What drives it at `ns`."""
        index = bisect_right(self.edges, ns, key=lambda edge: edge[0])
        return self.edges[index - 1][1] if index else None

    def level(self) -> bool:
        """The level now."""
        return self.level_at(self.now_ns)

    def level_at(self, ns: int) -> bool:
        """The level at `ns`."""
        return self.driven_at(ns) is True

    def mean(self, from_ns: int, to_ns: int) -> float:
        """The part of a span in which it was high."""
        if from_ns == to_ns:
            return float(self.level_at(to_ns))
        cuts = [from_ns, *(ns for ns, _ in self.edges if from_ns < ns < to_ns), to_ns]
        spans = itertools.pairwise(cuts)
        return sum(end - start for start, end in spans if self.level_at(start)) / (to_ns - from_ns)

    def changes(self, from_ns: int, to_ns: int) -> list[tuple[int, bool]]:
        """The changes in a span, its end among them; what changes nothing is none."""
        found, level = [], self.level_at(from_ns)
        for ns, driven in self.edges:
            if from_ns < ns <= to_ns and (driven is True) is not level:
                level = driven is True
                found.append((ns, level))
        return found

    def before_change(self, callback: Callable[[], None]) -> None:
        """Have `callback` called before each change."""
        self._before_change.append(callback)

    def latch(self) -> bool:
        """The output latch."""
        return self.level() if self.latched is None else self.latched


class PartBench:
    """One part with a wire at each terminal, and bench time.

    Args:
        kind: class of the part.
        settings: of it.
        quantities: called with a time in ns; returns what the world has then.
        step_ns: length of a physics step; 0 for no steps.

    Attributes:
        wires: by terminal.
        events: what the part told, with the time of the call.
        sent: bytes that it sent, as above.
        rates: what it said of the rate of its serial end, as above.
        quantities_out: the last quantities that went out.
        now_ns: the present.
    """

    def __init__(
        self,
        kind: type[Part],
        settings: object,
        *,
        quantities: Callable[[int], Mapping[str, float]] | None = None,
        step_ns: int = 0,
    ) -> None:
        self.wires = {terminal.name: Wire() for terminal in kind.TERMINALS}
        self.events: list[tuple[int, object]] = []
        self.sent: list[tuple[int, bytes]] = []
        self.rates: list[tuple[int, int]] = []
        self.quantities_out: Mapping[str, float] = {}
        self.now_ns = 0
        self._quantities = quantities or (lambda _ns: {})
        self._step_ns = step_ns
        self._next_step_ns = 0
        directions = {terminal.name: terminal.direction for terminal in kind.TERMINALS}
        ports = Ports(
            inputs={name: wire for name, wire in self.wires.items() if directions[name] is Direction.IN},
            outputs={name: wire for name, wire in self.wires.items() if directions[name] is Direction.OUT},
            analogs=self.wires,
            serial=lambda data: self.sent.append((self.now_ns, data)),
            rate=lambda baud: self.rates.append((self.now_ns, baud)),
            tell=lambda event: self.events.append((self.now_ns, event)),
        )
        self.part = kind(settings, ports, seed=1)
        self.part.power_on(0)

    def run_to(self, end_ns: int) -> None:
        """Let time pass, and do everything that is due up to and at `end_ns`."""
        while (due_ns := self._due_ns()) is not None and due_ns <= end_ns:
            self._go_to(due_ns)
            self.part.advance(due_ns)
            if self._step_ns and due_ns == self._next_step_ns:
                self._step()
        self._go_to(end_ns)

    def run(self, duration_s: float) -> None:
        """Let so many seconds pass."""
        self.run_to(self.now_ns + round(duration_s * 1e9))

    def receive(self, data: bytes) -> None:
        """Bytes come in now."""
        self.part.receive(data, self.now_ns)

    def told(self, kind: type) -> list[object]:
        """The events of a class, without their times."""
        return [event for _, event in self.events if isinstance(event, kind)]

    def _due_ns(self) -> int | None:
        deadline_ns = self.part.next_deadline_ns()
        if not self._step_ns:
            return deadline_ns
        return self._next_step_ns if deadline_ns is None else min(deadline_ns, self._next_step_ns)

    def _go_to(self, ns: int) -> None:
        self.now_ns = ns
        for wire in self.wires.values():
            wire.now_ns = ns

    def _step(self) -> None:
        start_ns, end_ns = self.now_ns, self.now_ns + self._step_ns
        self._next_step_ns = end_ns
        self.part.feed(self._quantities(start_ns))
        self.quantities_out = self.part.before_step(start_ns, end_ns)
        self.part.after_step(start_ns, end_ns, self._quantities(start_ns), self._quantities(end_ns))
