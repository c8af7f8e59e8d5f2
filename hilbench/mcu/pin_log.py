"""What pins do, for the journal: slow pins edge by edge, fast ones as period and duty.

Time is cut into windows of 100 ms. The first 20 edges of a pin in a window are events of their own; with more of them
the pin is fast, and the window ends with one event that says how many edges there were, what the last whole period was
like and which level it ended with. In the window after that there are no single edges, and where nobody wants them all,
only its first 10 ms are looked at. (All choices.)
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial

from hilbench.bench import Bench
from hilbench.clock import NS_PER_MS, EventClass
from hilbench.mcu.group import MachineGroup
from targets.mcu.pins import Edge, Pin

__all__ = ["PinLog"]

WINDOW_NS = 100 * NS_PER_MS
LOOK_NS = 10 * NS_PER_MS
SLOW_EDGES = 20

OnEdges = Callable[[str, list[Edge]], None]


@dataclass(slots=True)
class _Watched:
    """A pin and what it has done in this window."""

    pin: Pin
    count: int = 0
    was_fast: bool = False
    level: bool | None = None
    last: list[Edge] = field(default_factory=list)

    def take(self, edges: list[Edge]) -> None:
        self.count += len(edges)
        self.level = edges[-1].level
        self.last = [*self.last, *edges][-3:]

    def period(self) -> tuple[int, int] | None:
        """Return length of the last whole period and how long it was high, in ns."""
        if len(self.last) < 3 or None in {edge.level for edge in self.last}:
            return None
        first, second, third = self.last
        high_ns = second.ns - first.ns if first.level else third.ns - second.ns
        return third.ns - first.ns, high_ns


class PinLog:
    """Records the pins of one board.

    Args:
        bench: whose journal it writes to.
        group: who lets the chip run.
        name: of the board in the bench.
        pins: what to record.
        everything: called with the name of a pin and all its edges, in time or ahead of it; None if nobody wants all.
    """

    def __init__(
        self,
        bench: Bench,
        group: MachineGroup,
        name: str,
        pins: Iterable[Pin],
        *,
        everything: OnEdges | None = None,
    ) -> None:
        self._bench = bench
        self._group = group
        self._name = name
        self._everything = everything
        self._watched = [_Watched(pin) for pin in pins]
        for watched in self._watched:
            watched.pin.record()
        group.after_round.append(self._collect)
        self._next(bench.now_ns + WINDOW_NS, self._end_window)

    def _next(self, when_ns: int, action: Callable[[], None]) -> None:
        self._bench.scheduler.at(when_ns, action, order=EventClass.CHECK, source=f"{self._name}.pins")

    def _collect(self, _reached_ns: int) -> None:
        for watched in self._watched:
            if watched.pin.recording and (edges := watched.pin.take_edges()):
                self._take(watched, edges)

    def _take(self, watched: _Watched, edges: list[Edge]) -> None:
        if self._everything is not None:
            self._everything(watched.pin.name, edges)
        alone = 0 if watched.was_fast else max(0, SLOW_EDGES - watched.count)
        for edge in edges[:alone]:
            action = partial(self._changed, watched.pin.name, edge.level)
            self._group.output(edge.ns, action, order=EventClass.CONTROL, source=self._source(watched), reacts=False)
        watched.take(edges)

    def _changed(self, pin: str, level: bool | None) -> None:
        self._bench.record("pin", f"{self._name}.{pin}", level=level)

    def _source(self, watched: _Watched) -> str:
        return f"{self._name}.{watched.pin.name}"

    def _end_window(self) -> None:
        self._collect(self._bench.now_ns)
        for watched in self._watched:
            span_ns = WINDOW_NS if watched.pin.recording else LOOK_NS
            fast = watched.count * WINDOW_NS > SLOW_EDGES * span_ns
            if fast or watched.was_fast:
                self._tell_fast(watched, span_ns)
            watched.was_fast = fast
            watched.count = 0
            if not watched.pin.recording:
                watched.pin.record()
        if self._everything is None and any(watched.was_fast for watched in self._watched):
            self._next(self._bench.now_ns + LOOK_NS, self._look_away)
        self._next(self._bench.now_ns + WINDOW_NS, self._end_window)

    def _tell_fast(self, watched: _Watched, span_ns: int) -> None:
        period = watched.period()
        about: dict[str, object] = {} if period is None else {"period_ns": period[0], "high_ns": period[1]}
        about |= {"edges": watched.count, "in_ns": span_ns, "level": watched.level}
        self._bench.record("pwm", self._source(watched), **about)

    def _look_away(self) -> None:
        """Let go of the pins that are fast still."""
        self._collect(self._bench.now_ns)
        for watched in self._watched:
            if watched.was_fast and watched.count * WINDOW_NS > SLOW_EDGES * LOOK_NS:
                watched.pin.record(on=False)
