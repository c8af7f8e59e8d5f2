"""The state machines of a case, drawn with the way that each has gone."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape

from hilbench.clock import NS_PER_S
from hilbench.files.names import printable
from hilbench.recordings.layout import Event

__all__ = ["Machine", "Transition", "machines_of"]

MOST_STATES = 14
MOST_TRANSITIONS = 40
WIDTH, HEIGHT, RADIUS_X, RADIUS_Y, NODE = 560, 300, 200, 110, 22
CHARACTERS = 18


@dataclass(frozen=True, slots=True)
class Transition:
    """From one state to another.

    Attributes:
        number: from 1 on, in the order of time.
        ns: bench time of the case.
        old: the state before.
        new: the state after.
        trigger: what led there.
    """

    number: int
    ns: int
    old: str
    new: str
    trigger: str

    @property
    def time_s(self) -> str:
        """Bench time in seconds, to the millisecond."""
        return f"{self.ns / NS_PER_S:.3f}"


@dataclass(frozen=True, slots=True)
class Machine:
    """A state machine.

    Attributes:
        source: whose it is.
        picture: its states and the ways between them that were taken, as SVG; empty if there are too many.
        transitions: the last of its transitions.
        left_out: how many there were before.
    """

    source: str
    picture: str
    transitions: tuple[Transition, ...]
    left_out: int


def machines_of(events: Sequence[Event]) -> list[Machine]:
    """Return the state machines that changed in a case, in the order of their first change."""
    found: dict[str, list[Transition]] = {}
    for event in events:
        value = event.get("value")
        if event.get("name") != "StateChanged" or not isinstance(value, Mapping) or type(event.get("ns")) is not int:
            continue
        own = found.setdefault(_cut(event.get("source", "")), [])
        names = (_cut(value.get(key, "")) for key in ("old", "new", "trigger"))
        own.append(Transition(len(own) + 1, event["ns"], *names))
    return [
        Machine(source, _picture(all_), tuple(all_[-MOST_TRANSITIONS:]), max(0, len(all_) - MOST_TRANSITIONS))
        for source, all_ in found.items()
    ]


def _cut(value: object) -> str:
    return printable(str(value))[:CHARACTERS]


def _picture(transitions: Sequence[Transition]) -> str:
    names = list(dict.fromkeys(name for one in transitions for name in (one.old, one.new)))
    if len(names) > MOST_STATES:
        return ""
    places = {name: _place(number, len(names)) for number, name in enumerate(names)}
    ways: dict[tuple[str, str], list[int]] = {}
    for one in transitions:
        ways.setdefault((one.old, one.new), []).append(one.number)
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif">'
    arrow = (
        '<defs><marker id="to" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="8" markerHeight="8" orient="auto">'
        '<path d="M0 0 8 4 0 8z" fill="#0072b2"/></marker></defs>'
    )
    edges = "".join(_edge(places, old, new, numbers) for (old, new), numbers in ways.items())
    return "".join([head, arrow, edges, *_nodes(places, transitions[-1].new), "</svg>"])


def _place(number: int, count: int) -> tuple[float, float]:
    angle = 2 * math.pi * number / count - math.pi / 2
    return WIDTH / 2 + RADIUS_X * math.cos(angle), HEIGHT / 2 + RADIUS_Y * math.sin(angle)


def _nodes(places: Mapping[str, tuple[float, float]], last: str) -> Iterator[str]:
    for name, (x, y) in places.items():
        half = _half_width(name)
        fill, ink = ("#0072b2", "#fff") if name == last else ("#fff", "#222")
        corner = f'x="{x - half:.0f}" y="{y - NODE / 2:.0f}" width="{2 * half}" height="{NODE}" rx="6"'
        yield f'<rect {corner} fill="{fill}" stroke="#0072b2"/>'
        place = f'x="{x:.0f}" y="{y + 4:.0f}" font-size="12" text-anchor="middle"'
        yield f'<text {place} fill="{ink}">{escape(name)}</text>'


def _half_width(name: str) -> int:
    return max(30, 4 * len(name) + 7)


def _edge(places: Mapping[str, tuple[float, float]], old: str, new: str, numbers: Sequence[int]) -> str:
    """Draw a way between two states, bent to its right, with the numbers of the transitions on it."""
    said = ", ".join(map(str, numbers[:4])) + (f" and {len(numbers) - 4} more" if len(numbers) > 4 else "")
    begin, end = places[old], places[new]
    if old == new:
        x, y = begin
        top, high = y - NODE / 2, y - 48
        path = f"M{x - 12:.0f} {top:.0f} C{x - 30:.0f} {high:.0f} {x + 30:.0f} {high:.0f} {x + 12:.0f} {top:.0f}"
        return _drawn(path, x, y - 42, said)
    across, down = end[0] - begin[0], end[1] - begin[1]
    length = math.hypot(across, down)
    middle = (begin[0] + end[0]) / 2 - 30 * down / length, (begin[1] + end[1]) / 2 + 30 * across / length
    (x0, y0), (x1, y1) = _border(begin, old, middle), _border(end, new, middle)
    path = f"M{x0:.0f} {y0:.0f} Q{middle[0]:.0f} {middle[1]:.0f} {x1:.0f} {y1:.0f}"
    return _drawn(path, (x0 + 2 * middle[0] + x1) / 4, (y0 + 2 * middle[1] + y1) / 4, said)


def _border(node: tuple[float, float], name: str, towards: tuple[float, float]) -> tuple[float, float]:
    """Return where a line from the middle of a state leaves its frame."""
    across, down = towards[0] - node[0], towards[1] - node[1]
    beside = (_half_width(name) + 2) / abs(across) if across else math.inf
    above = (NODE / 2 + 2) / abs(down) if down else math.inf
    share = min(beside, above, 1.0)
    return node[0] + share * across, node[1] + share * down


def _drawn(path: str, x: float, y: float, said: str) -> str:
    return (
        f'<path d="{path}" fill="none" stroke="#0072b2" stroke-width="1.3" marker-end="url(#to)"/>'
        f'<text x="{x:.0f}" y="{y:.0f}" font-size="11" text-anchor="middle" fill="#b35900">{said}</text>'
    )
