"""How fast the vehicle was over a case, drawn from where it was recorded to be."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

from hilbench.clock import NS_PER_S
from hilbench.recordings.layout import Event
from hilbench.recordings.moments import pose_of
from worlds.errors import WorldError

__all__ = ["speeds_of"]

WIDTH, HEIGHT, LEFT, BELOW = 640, 120, 90, 20
MOST_POINTS = 600
_MM = 1000.0


def speeds_of(events: Sequence[Event]) -> str:
    """Return the speed over time as SVG; empty if no vehicle moved.

    A journal has the place of a vehicle ten times a second: what is drawn is the mean speed in between.
    """
    try:
        known = [(event["ns"], pose_of(event).position_m) for event in events if _is_pose(event)]
    except WorldError:
        return ""
    every = max(1, math.ceil(len(known) / MOST_POINTS))
    steps = list(_steps(known[::every]))
    top = max((speed for _, speed in steps), default=0.0)
    if top <= 0:
        return ""
    begin_ns, end_ns = min(ns for ns, _ in known), max(ns for ns, _ in known)
    points = " ".join(
        f"{LEFT + WIDTH * (ns - begin_ns) / (end_ns - begin_ns):.1f},{HEIGHT - (HEIGHT - 12) * speed / top:.1f}"
        for ns, speed in steps
    )
    marks = [
        _text(LEFT - 6, 16, f"{top:.0f} mm/s", "end"),
        _text(LEFT - 6, HEIGHT, "0", "end"),
        _text(LEFT, HEIGHT + 14, f"{begin_ns / NS_PER_S:.3f} s", "start"),
        _text(LEFT + WIDTH, HEIGHT + 14, f"{end_ns / NS_PER_S:.3f} s", "end"),
    ]
    size = f'width="{LEFT + WIDTH}" height="{HEIGHT + BELOW}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif">'
    axis = f'<path d="M{LEFT} 8V{HEIGHT}H{LEFT + WIDTH}" fill="none" stroke="#999"/>'
    line = f'<polyline points="{points}" fill="none" stroke="#0072b2" stroke-width="1.4"/>'
    return "".join([head, axis, line, *marks, "</svg>"])


def _is_pose(event: Event) -> bool:
    return event["kind"] == "pose" and type(event.get("ns")) is int


def _steps(known: Sequence[tuple[int, Sequence[float]]]) -> Iterator[tuple[int, float]]:
    """Yield the mean speed in mm/s between each place and the next, at the end of that time."""
    for (begin_ns, begin_m), (end_ns, end_m) in pairwise(known):
        if end_ns > begin_ns:
            yield end_ns, _MM * math.dist(begin_m[:2], end_m[:2]) * NS_PER_S / (end_ns - begin_ns)


def _text(x: float, y: float, said: str, anchor: str) -> str:
    return f'<text x="{x:.0f}" y="{y:.0f}" font-size="10" fill="#777" text-anchor="{anchor}">{said}</text>'
