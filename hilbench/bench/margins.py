"""Keeps how much time was left of each timer, such as a watchdog, whenever it was set anew, and when it ran out.

It looks whenever a device of the bench has been called, so each time is exact. It puts nothing into the journal before
the verdict, and what it then says is in no hash: a case that is looked at has the hash it always had.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from hilbench.bench import Bench
from hilbench.bench.state_reporter import Observed, Sense, Senses, left_ns
from hilbench.journal.run_hash import MARGINS

__all__ = ["MOST_POINTS", "Margins", "Point"]

MOST_POINTS = 1000
"""Of a timer; of more, the least of each two in a row is kept (choice: several for each pixel of a plot)."""

_LATEST_NS = 2**62 - 1
"""The latest time that readers of a recording take."""

Point = tuple[int, int, int]
"""Bench time, what was left then, and the span for which the timer had been set, all in ns."""


@dataclass(slots=True)
class _Timer:
    deadline_ns: int | None = None
    span_ns: int = 0
    points: list[Point] = field(default_factory=list)

    def look(self, deadline_ns: int | None, now_ns: int, sense: Sense) -> None:
        if deadline_ns == self.deadline_ns:
            return
        left = left_ns(self.deadline_ns, deadline_ns, now_ns, sense)
        if left is not None and self.deadline_ns is not None:
            self.points.append((min(now_ns, self.deadline_ns), left, self.span_ns))
            if len(self.points) > MOST_POINTS:
                self.points = _thinned(self.points)
        self.deadline_ns = deadline_ns
        if deadline_ns is not None:
            self.span_ns = max(0, deadline_ns - now_ns)


class Margins:
    """See the module.

    Args:
        bench: whose devices are looked at.
        machines: says which state machines there are, by their source in the journal; asked again and again, since a
            case builds only what it uses.
        senses: what the ends of timers mean.
    """

    def __init__(self, bench: Bench, machines: Callable[[], Mapping[str, Observed]], senses: Senses) -> None:
        self._bench = bench
        self._machines = machines
        self._senses = senses
        self._timers: dict[str, dict[str, _Timer]] = {}
        self._blind: set[str] = set()
        bench.on_settled = self._look

    def end(self) -> None:
        """Look once more, and then no longer."""
        self._look()
        self._bench.on_settled = None

    def record(self) -> None:
        """Take into the journal what was found of each timer, if anything was."""
        for machine, timers in self._timers.items():
            for name, timer in timers.items():
                if timer.points:
                    self._bench.record(MARGINS, machine, timer=name, points=timer.points)

    def _look(self) -> None:
        for machine, observed in self._machines().items():
            if machine not in self._blind:
                try:
                    self._look_at(machine, observed)
                except Exception:  # noqa: BLE001 - a plug-in's machine; whether it is looked at must change no verdict
                    self._blind.add(machine)

    def _look_at(self, machine: str, observed: Observed) -> None:
        now_ns = self._bench.now_ns
        deadlines = {timer.name: min(max(0, int(at_ns)), _LATEST_NS) for timer, at_ns in observed.deadlines.items()}
        timers = self._timers.setdefault(machine, {})
        for name in dict.fromkeys((*timers, *deadlines)):
            sense = self._senses.get(machine, {}).get(name, Sense.WATCHDOG)
            timers.setdefault(name, _Timer()).look(deadlines.get(name), now_ns, sense)


def _thinned(points: list[Point]) -> list[Point]:
    """Return of each two in a row the one of which less was left."""
    return [min(points[at : at + 2], key=lambda point: point[1]) for at in range(0, len(points), 2)]
