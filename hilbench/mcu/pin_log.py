"""What pins do, for the journal: slow pins edge by edge, fast ones as period and duty.

Time is cut into windows of 100 ms. The first 20 edges of a pin in a window are events of their own; with more of them
the pin is fast, and the window ends with one event that says how many edges there were, what the last whole period was
like and which level it ended with. In the window after that there are no single edges, and where nobody wants them all,
only its first 10 ms are looked at. (All choices.) What is too fast for edges, as a clock at a pin, is recorded when it
changes and at the end of each window, with the number of edges since it was recorded last.

The edges of serial frames are left out, unless they are asked for: what was sent stands in the journal as bytes. A pin
that carries TX when a frame begins carries that frame; its edges until the frame ends are the frame's. That edges are
left out is recorded with the first frame, once for each pin.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

from hilbench.bench import Bench
from hilbench.clock import NS_PER_MS, NS_PER_S, EventClass
from hilbench.mcu.group import MachineGroup
from targets.mcu.pins import Edge, Pin, Pins
from targets.mcu.serial_line import SerialFrame
from targets.mcu.services import Wave

__all__ = ["PinLog"]

WINDOW_NS = 100 * NS_PER_MS
LOOK_NS = 10 * NS_PER_MS
SLOW_EDGES = 20

OnEdges = Callable[[str, list[Edge]], None]


@dataclass(slots=True)
class _Watched:
    """A pin and what it has done in this window.

    Attributes:
        pin: the pin.
        place: its place among the others.
        seen: all its edges in this window, and
        count: those of them that are to be recorded.
        was_busy: whether there were many edges in the window before, and
        was_fast: whether there were many to be recorded.
        level: after the last edge that was to be recorded.
        last: the last three of them.
        frames: the serial frames that its next edges may belong to.
        carries: whether there were any.
        wave: what it carries that is too fast for edges, and
        wave_ns: when that was recorded last.
    """

    pin: Pin
    place: int
    seen: int = 0
    count: int = 0
    was_busy: bool = False
    was_fast: bool = False
    level: bool | None = None
    last: list[Edge] = field(default_factory=list)
    frames: deque[SerialFrame] = field(default_factory=deque)
    carries: bool = False
    wave: Wave | None = None
    wave_ns: int = 0

    def without_frames(self, edges: list[Edge]) -> list[Edge]:
        """Return the edges that belong to no frame."""
        return [edge for edge in edges if not self._of_frame(edge)] if self.frames else edges

    def _of_frame(self, edge: Edge) -> bool:
        while self.frames and self.frames[0].end_ns <= edge.ns:
            self.frames.popleft()
        return bool(self.frames) and self.frames[0].start_ns <= edge.ns and edge.level is not None

    def forget_frames(self, ns: int) -> None:
        """Forget what ended before `ns`, up to which all edges have been taken."""
        while len(self.frames) > 1 and self.frames[1].start_ns <= ns:
            self.frames.popleft()

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
        pins: of its chip; those that the package has are recorded.
        everything: called with the name of a pin and all its edges, in time or ahead of it; None if nobody wants all.
    """

    def __init__(
        self,
        bench: Bench,
        group: MachineGroup,
        name: str,
        pins: Pins,
        *,
        everything: OnEdges | None = None,
    ) -> None:
        self._bench = bench
        self._group = group
        self._name = name
        self._everything = everything
        self._pins = pins
        self._watched = [_Watched(pin, place) for place, pin in enumerate(pin for pin in pins if pin.bonded)]
        self._by_name = {watched.pin.name: watched for watched in self._watched}
        for watched in self._watched:
            watched.pin.follow()
            watched.wave, watched.wave_ns = watched.pin.wave, bench.now_ns
            watched.pin.on_wave = partial(self._wave_changed, watched)
        group.after_round.append(self._collect)
        self._next(bench.now_ns + WINDOW_NS, self._end_window)

    def leave_out(self, pin: str, frame: SerialFrame) -> None:
        """Tell nothing of the edges of a frame that begins now at a pin."""
        watched = self._by_name.get(pin)
        if watched is not None:
            if not watched.pin.following:
                watched.frames.clear()
            elif self._everything is None:
                watched.pin.pass_over(len(frame.edge_bits()))
            watched.frames.append(frame)
            if not watched.carries:
                watched.carries = True
                tell = partial(self._bench.record, "frames", self._name, pin=pin)
                self._group.output(frame.start_ns, tell, order=EventClass.CONTROL, source=self._name, reacts=False)

    def _next(self, when_ns: int, action: Callable[[], None]) -> None:
        self._bench.scheduler.at(when_ns, action, order=EventClass.CHECK, source=f"{self._name}.pins")

    def _collect_all(self) -> None:
        """Count those that were left out as well."""
        now_ns = self._bench.now_ns
        for watched in self._watched:
            if watched.frames:
                watched.seen += watched.pin.take_passed()
        self._collect(now_ns)
        for watched in self._watched:
            watched.forget_frames(now_ns)

    def _collect(self, _reached_ns: int) -> None:
        taken = [(self._by_name[pin.name], edges) for pin, edges in self._pins.take_followed()]
        for watched, edges in sorted(taken, key=lambda each: each[0].place):
            self._take(watched, edges)

    def _take(self, watched: _Watched, edges: list[Edge]) -> None:
        if self._everything is not None:
            self._everything(watched.pin.name, edges)
        watched.seen += len(edges)
        if edges := watched.without_frames(edges):
            self._tell(watched, edges)

    def _tell(self, watched: _Watched, edges: list[Edge]) -> None:
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
        self._collect_all()
        for watched in self._watched:
            span_ns = WINDOW_NS if watched.pin.following else LOOK_NS
            fast = watched.count * WINDOW_NS > SLOW_EDGES * span_ns
            if watched.wave is not None:
                self._tell_wave(watched, self._bench.now_ns, watched.wave)
            if fast or watched.was_fast:
                self._tell_fast(watched, span_ns)
            watched.was_fast = fast
            watched.was_busy = watched.seen * WINDOW_NS > SLOW_EDGES * span_ns
            watched.seen = watched.count = 0
            if not watched.pin.following:
                watched.pin.follow()
        if self._everything is None and any(watched.was_busy for watched in self._watched):
            self._next(self._bench.now_ns + LOOK_NS, self._look_away)
        self._next(self._bench.now_ns + WINDOW_NS, self._end_window)

    def _tell_fast(self, watched: _Watched, span_ns: int) -> None:
        period = watched.period()
        about: dict[str, object] = {} if period is None else {"period_ns": period[0], "high_ns": period[1]}
        about |= {"edges": watched.count, "in_ns": span_ns, "level": watched.level}
        self._bench.record("pwm", self._source(watched), **about)

    def _wave_changed(self, watched: _Watched, wave: Wave | None) -> None:
        ns = watched.pin.now_ns()
        action = partial(self._tell_wave, watched, ns, wave)
        self._group.output(ns, action, order=EventClass.CONTROL, source=self._source(watched), reacts=False)

    def _tell_wave(self, watched: _Watched, ns: int, wave: Wave | None) -> None:
        """Tell of the wave up to now, and of the one from now on."""
        old, in_ns = watched.wave, ns - watched.wave_ns
        watched.wave, watched.wave_ns = wave, ns
        about: dict[str, object] = {"edges": 0, "in_ns": 0}
        if old is not None:
            about = {"edges": int(2 * old.hz * in_ns / NS_PER_S), "in_ns": in_ns}
        if wave is not None:
            period_ns = NS_PER_S / wave.hz
            about |= {"period_ns": round(period_ns), "high_ns": round(period_ns * wave.duty), "duty": float(wave.duty)}
        self._bench.record("pwm", self._source(watched), **about, level=False)

    def _look_away(self) -> None:
        """Let go of the pins that are busy still."""
        self._collect_all()
        for watched in self._watched:
            if watched.was_busy and watched.seen * WINDOW_NS > SLOW_EDGES * LOOK_NS:
                watched.pin.follow(on=False)
