"""The last moments of a case, from a recording: what was said, what happened, levels of pins, where the vehicle was."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape

from hilbench.check.page.margins import margins_of
from hilbench.check.page.speed import speeds_of
from hilbench.check.page.states import Machine, machines_of
from hilbench.clock import NS_PER_S
from hilbench.errors import HilbenchError
from hilbench.files.names import printable
from hilbench.journal import Recording
from hilbench.journal.run_hash import MARGINS
from hilbench.plugins.protocol import ProtocolPlugin
from hilbench.recordings.above import map_of
from hilbench.recordings.frames import framed
from hilbench.recordings.layout import Event, of_case, without
from hilbench.recordings.moments import moment_of
from protocols.common.items import Kind

__all__ = ["Line", "Story", "story_of"]

MOST_LINES = 80
MOST_PINS = 12
MOST_EDGES = 400  # of a pin, in the time that is shown
MOST_BYTES = 48
MOST_CHARACTERS = 200
LONGEST_NS = 2 * NS_PER_S
MAP_PX = (560, 420)
PIN_PX, PLOT_PX, NAME_PX = 22, 640, 90
_NO_LINES = {"tx", "rx", "dropped", "pin", "pwm", "pose", "scene", "case", "case-end", "frames", MARGINS}


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """Something that was said or happened.

    Attributes:
        ns: bench time of the case.
        way: ``tx``, ``rx`` or empty for an event, as its source sees it.
        source: who says it, at which of its lines, or to whom it happens.
        name: of the message, or kind of the event.
        text: its fields.
        raw: its bytes, in hexadecimal.
        bad: whether it is no sound frame, on a line on which there are some.
    """

    ns: int
    way: str
    source: str
    name: str
    text: str
    raw: str = ""
    bad: bool = False

    @property
    def time_s(self) -> str:
        """Bench time in seconds, to the millisecond."""
        return f"{self.ns / NS_PER_S:.3f}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Story:
    """See the module.

    Attributes:
        case: whose.
        lines: the last of them, in the order of time.
        left_out: how many there were before.
        pins: their levels as SVG; empty if none has changed.
        map: the world from above as SVG; empty if there is none.
        machines: the state machines that changed.
        speeds: of the vehicle over the case, as SVG; empty if none moved.
        margins: how much time timers had left over the case, as SVG; empty if none was set anew or ran out.
    """

    case: str
    lines: tuple[Line, ...]
    left_out: int
    pins: str
    map: str
    machines: tuple[Machine, ...]
    speeds: str
    margins: str


def story_of(recording: Recording, case: str, protocol: ProtocolPlugin | None) -> Story | None:
    """Return the story of a case; None if the recording has none of that name.

    Args:
        recording: of the run.
        case: its id.
        protocol: what is spoken; None where nobody knows.
    """
    try:
        own = of_case(recording, case, "")
    except HilbenchError:
        return None
    lines = sorted(_lines(own, protocol), key=lambda line: line.ns)
    return Story(
        case=case,
        lines=tuple(lines[-MOST_LINES:]),
        left_out=max(0, len(lines) - MOST_LINES),
        pins=_pins(own.events),
        map=_map(own),
        machines=tuple(machines_of(own.events)),
        speeds=speeds_of(own.events),
        margins=margins_of(own.events),
    )


def _lines(recording: Recording, protocol: ProtocolPlugin | None) -> Iterator[Line]:
    """Yield what was said and what happened.

    Nothing says which lines of a bench speak the protocol: whoever neither sent nor got a frame of it speaks another.
    """
    events = [(event["ns"], event) for event in recording.events if type(event.get("ns")) is int]
    if protocol is not None:
        found = list(framed(events, protocol))
        speak = {(one.source, one.line) for one in found if one.item.kind is Kind.FRAME}
        for one in found:
            item, speaks = one.item, (one.source, one.line) in speak
            fields = ", ".join(f"{name} {value}" for name, value in item.fields.items())
            yield Line(
                ns=one.ns,
                way=one.kind,
                source=_cut(f"{one.source}{one.line and '.'}{one.line}"),
                name=_cut(item.name) if speaks else "bytes",
                text=_cut(fields),
                raw=_hex(item.raw),
                bad=item.kind is not Kind.FRAME and speaks,
            )
    for ns, event in events:
        if event["kind"] not in _NO_LINES:
            text = json.dumps(without(event, "ns", "kind", "source", "name"), ensure_ascii=False)
            name = f"{event['kind']} {event['name']}" if "name" in event else str(event["kind"])
            yield Line(ns=ns, way="", source=_cut(str(event.get("source", ""))), name=_cut(name), text=_cut(text))


def _hex(data: bytes) -> str:
    more = len(data) - MOST_BYTES
    return data[:MOST_BYTES].hex(" ") + (f" and {more} more" if more > 0 else "")


def _cut(text: str) -> str:
    text = printable(text)
    return text if len(text) <= MOST_CHARACTERS else f"{text[:MOST_CHARACTERS]}…"


def _map(recording: Recording) -> str:
    try:
        return map_of(
            moment_of(recording, None, ""), MAP_PX, title="", note="dots: where it was, to the end of the case"
        )
    except HilbenchError:
        return ""


# --- pins


def _pins(events: Sequence[Event]) -> str:
    """Draw the pins that changed last, over the last seconds of the case."""
    levels: dict[str, list[tuple[int, bool | None]]] = {}
    end_ns = 0
    for event in events:
        ns = event.get("ns")
        if type(ns) is int:
            end_ns = max(end_ns, ns)
            if event["kind"] == "pin":
                levels.setdefault(str(event["source"]), []).append((ns, _level(event)))
    begin_ns = max(0, end_ns - LONGEST_NS)
    moved = {pin: edges for pin, edges in levels.items() if len(edges) > 1 and edges[-1][0] >= begin_ns}
    if not moved or end_ns <= begin_ns:
        return ""
    names = sorted(sorted(moved, key=lambda pin: -moved[pin][-1][0])[:MOST_PINS])
    height = PIN_PX * len(names) + 20
    rows = [_wave(number, pin, moved[pin], begin_ns, end_ns) for number, pin in enumerate(names)]
    marks = [
        f'<text x="{NAME_PX + share * PLOT_PX:.0f}" y="{height - 5}" font-size="10" fill="#777" '
        f'text-anchor="{anchor}">{(begin_ns + share * (end_ns - begin_ns)) / NS_PER_S:.3f} s</text>'
        for share, anchor in ((0, "start"), (1, "end"))
    ]
    size = f'width="{NAME_PX + PLOT_PX}" height="{height}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif">'
    return "".join([head, *rows, *marks, "</svg>"])


def _level(event: Mapping[str, object]) -> bool | None:
    level = event.get("level")
    return level if isinstance(level, bool) else None


def _wave(number: int, pin: str, edges: Sequence[tuple[int, bool | None]], begin_ns: int, end_ns: int) -> str:
    def x(ns: int) -> float:
        return NAME_PX + PLOT_PX * (max(ns, begin_ns) - begin_ns) / (end_ns - begin_ns)

    top = PIN_PX * number + 5
    y = {True: top, False: top + 12, None: top + 6}
    before = next((level for ns, level in reversed(edges) if ns < begin_ns), edges[0][1])
    points = [f"{NAME_PX},{y[before]}"]
    for ns, level in [edge for edge in edges if edge[0] >= begin_ns][-MOST_EDGES:]:
        points += [f"{x(ns):.1f},{points[-1].partition(',')[2]}", f"{x(ns):.1f},{y[level]}"]
    points.append(f"{NAME_PX + PLOT_PX},{points[-1].partition(',')[2]}")
    name = f'<text x="0" y="{top + 11}" font-size="11" fill="#777">{escape(printable(pin)[-14:])}</text>'
    return f'{name}<polyline points="{" ".join(points)}" fill="none" stroke="#0072b2" stroke-width="1.2"/>'
