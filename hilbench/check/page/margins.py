"""How much time was left of timers, such as watchdogs, each time they were set anew over a case, drawn."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape

from hilbench.clock import NS_PER_MS, NS_PER_S
from hilbench.files.names import printable
from hilbench.journal.run_hash import MARGINS
from hilbench.recordings.layout import Event

__all__ = ["margins_of"]

WIDTH, LEFT, RIGHT = 640, 90, 6
ABOVE, HEIGHT, BELOW = 24, 64, 20  # of a timer: its name, its plot; below all of them the time
MOST_TIMERS = 6
MOST_POINTS = 1000  # of a timer, the last of them
MOST_DOTS = 100  # of a timer; of more the line is drawn alone
MOST_CHARACTERS = 40
_LINE, _OUT = "#0072b2", "#c0262d"

Point = Sequence[int]
"""Bench time, what was left, and the span of the timer then, in ns."""


@dataclass(frozen=True, slots=True)
class _Timer:
    """A timer of a machine, and what was seen of it."""

    name: str
    points: Sequence[Point]

    @property
    def least(self) -> Point:
        """The point at which the least part of its span was left."""
        return min(self.points, key=lambda point: point[1] / max(point[2], 1))

    @property
    def share(self) -> float:
        """The least part of its span that was left."""
        return self.least[1] / max(self.least[2], 1)


def margins_of(events: Sequence[Event]) -> str:
    """Return a plot for each timer as SVG, under one axis of time; empty if none was set anew or ran out.

    Of many timers it has those that came nearest to their end.
    """
    all_timers = sorted(_timers(events), key=lambda timer: timer.share)
    timers = all_timers[:MOST_TIMERS]
    if not timers:
        return ""
    times = [event["ns"] for event in events if type(event.get("ns")) is int]
    times += [point[0] for timer in timers for point in timer.points]
    begin_ns = min(times)
    end_ns = max(*times, begin_ns + 1)
    plots = [_plot(number, timer, begin_ns, end_ns) for number, timer in enumerate(timers)]
    height = len(timers) * (ABOVE + HEIGHT) + BELOW
    more = len(all_timers) - len(timers)
    marks = [
        _text(LEFT, height - 5, _seconds(begin_ns), "start"),
        _text(LEFT + WIDTH, height - 5, _seconds(end_ns), "end"),
    ]
    marks += [_text(LEFT + WIDTH / 2, height - 5, f"{more} more came less near to their end", "middle")] if more else []
    size = f'width="{LEFT + WIDTH + RIGHT}" height="{height}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif">'
    return "".join([head, *plots, *marks, "</svg>"])


def _timers(events: Sequence[Event]) -> Iterator[_Timer]:
    for event in events:
        if event["kind"] == MARGINS and event["points"]:
            yield _Timer(f"{event['source']} {event['timer']}", event["points"][-MOST_POINTS:])


def _plot(number: int, timer: _Timer, begin_ns: int, end_ns: int) -> str:
    """Draw a timer: how much was left, its span above, and zero, where it runs out."""
    floor = (number + 1) * (ABOVE + HEIGHT)
    top_ns = max(1, *(max(point[1:3]) for point in timer.points))

    def x(ns: int) -> float:
        return LEFT + WIDTH * (ns - begin_ns) / (end_ns - begin_ns)

    def y(left_ns: int) -> float:
        return floor - HEIGHT * left_ns / top_ns

    line = " ".join(f"{x(ns):.1f},{y(left):.1f}" for ns, left, _ in timer.points)
    span = "".join(f"V{y(span):.1f}H{x(ns):.1f}" for ns, _, span in timer.points)
    return "".join([
        f'<path d="M{LEFT} {floor}H{LEFT + WIDTH}" stroke="#999"/>',
        f'<path d="M{LEFT} {y(timer.points[0][2]):.1f}{span}H{LEFT + WIDTH}" fill="none" stroke="#ccc"/>',
        f'<polyline points="{line}" fill="none" stroke="{_LINE}" stroke-width="1.2"/>',
        *(_dot(x(ns), y(left), left, many=len(timer.points) > MOST_DOTS) for ns, left, _ in timer.points),
        _text(LEFT, floor - HEIGHT - 6, _told(timer), "start"),
        _text(LEFT - 6, floor - HEIGHT + 4, _duration(top_ns), "end"),
        _text(LEFT - 6, floor + 4, "0", "end"),
    ])  # fmt: skip


def _dot(x: float, y: float, left_ns: int, *, many: bool) -> str:
    """Mark a point, in red where the timer ran out."""
    if not left_ns:
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{_OUT}"/>'
    return "" if many else f'<circle cx="{x:.1f}" cy="{y:.1f}" r="1.8" fill="{_LINE}"/>'


def _told(timer: _Timer) -> str:
    """Say of a timer what its plot shows."""
    name = printable(timer.name)
    name = name if len(name) <= MOST_CHARACTERS else f"{name[:MOST_CHARACTERS]}…"
    ran_out = sum(not left for _, left, _ in timer.points)
    _, left_ns, span_ns = timer.least
    said = f"ran out {ran_out} times" if ran_out > 1 else "ran out" if ran_out else f"least {_duration(left_ns)} left"
    return f"{name}, set for {_duration(span_ns)}: {said}"


def _duration(ns: int) -> str:
    return f"{ns / NS_PER_S:.4g} s" if ns >= NS_PER_S else f"{ns / NS_PER_MS:.4g} ms"


def _seconds(ns: int) -> str:
    return f"{ns / NS_PER_S:.3f} s"


def _text(x: float, y: float, said: str, anchor: str) -> str:
    return f'<text x="{x:.0f}" y="{y:.0f}" font-size="11" fill="#555" text-anchor="{anchor}">{escape(said)}</text>'
