"""The page and the picture."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from xml.sax.saxutils import escape

from measure.deadlines.measure import BYTE_S, EVENTS, Event, Sample
from measure.deadlines.spread import spread_of

__all__ = ["Samples", "page", "picture"]

Samples = Mapping[str, Sequence[Sample]]
"""By the names of `EVENTS`."""

TICK_S = 0.001
"""A tick of the boards' kernels: what firmware may be off."""

_HEAD = """\
# Deadlines of the vehicle-interface board, measured

Made by `make deadlines` (`python -m measure.deadlines`). Do not edit.

A board between a driving stack that commands 30 times a second and a simulator that reports 20 times a second. One of
them falls silent, or comes back, at a moment drawn by chance (seed {seed}), {count} times each; the phase of both
streams is drawn anew each time. Documented are the waits of the original (LMA-FEM-UNICAMP/microAutoware,
`src/HIL/taksControl.h`): 110 ms for a command, 100 ms for a status, ten in a row until the mode changes, 60 ms of pause
in MANUAL.

*Model* is the behavioural board, *firmware* our own (`targets/firmware/vehicle_interface`) on an emulated
NUCLEO-H753ZI, each in the profile that is named.

*Counted* is what the board itself counts: frame to frame, so a whole number of documented waits. *Seen* is what a user
sees: from the last byte of the last command or status to the first frame of the new mode; the phase decides how much
longer it is. Times are bench time; a frame's begin is known to a byte on the line, {byte_us:.1f} µs. ± is two standard
errors of the mean and that byte. *Within* says whether every single time lies between what is expected at least and at
most, give or take a tick of the board's kernel, 1 ms.

![Every time over what is documented](../images/carla-deadlines.svg)
"""


def page(measured: Mapping[str, Samples], seed: int) -> str:
    """Return the page.

    Args:
        measured: by the names of the boards.
        seed: of the phases.
    """
    count = min(len(samples) for board in measured.values() for samples in board.values())
    lines = [_HEAD.format(count=count, seed=seed, byte_us=BYTE_S * 1e6)]
    for name, event in EVENTS.items():
        lines += [f"## {event.name}\n", *_expected(event)]
        lines += ["| Board | Time | Documented, ms | Least | Mean | Most | Standard deviation | Within |"]
        lines += ["|---|---|--:|--:|--:|--:|--:|---|"]
        for board, samples in measured.items():
            lines += _rows(board, event, samples[name])
        lines.append("")
    return "\n".join(lines)


def _expected(event: Event) -> Iterable[str]:
    if event.deadline_s is not None:
        yield f"Counted: {event.counted}.\n"
    yield f"Seen: {event.seen}.\n"


def _rows(board: str, event: Event, samples: Sequence[Sample]) -> Iterable[str]:
    counted = [sample.deadline_s for sample in samples if sample.deadline_s is not None]
    if event.deadline_s is not None:
        yield _row(board, "counted", counted, event.deadline_s, event.deadline_s)
    yield _row(board, "seen", [sample.seen_s for sample in samples], event.seen_least_s, event.seen_most_s)


def _row(board: str, what: str, times_s: Sequence[float], least_s: float, most_s: float) -> str:
    spread = spread_of(times_s, BYTE_S)
    documented = _ms(least_s) if least_s == most_s else f"{_ms(least_s)} to {_ms(most_s)}"
    within = "yes" if spread.within(least_s, most_s, TICK_S + BYTE_S) else "**no**"
    mean = f"{_ms(spread.mean_s, 2)} ± {_ms(spread.uncertainty_s, 2)}"
    cells = (board, what, documented, _ms(spread.least_s, 2), mean, _ms(spread.most_s, 2), _ms(spread.deviation_s, 2))
    return f"| {' | '.join(cells)} | {within} |"


def _ms(time_s: float, digits: int = 0) -> str:
    return f"{time_s * 1e3 + 0.0:.{digits}f}".replace("-0.00", "0.00")


# --- the picture

_FONT = 'font-family="sans-serif" font-size="12"'
_WIDTH, _LEFT, _RIGHT, _TOP = 760, 250, 20, 40
_ROW, _GAP = 26, 14
_FIRST_MS, _LAST_MS = -10, 130
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")


def picture(measured: Mapping[str, Samples]) -> str:
    """Return the picture: each time that a user sees as a dot, what is expected as a bar behind it."""
    height = _TOP + len(EVENTS) * (len(measured) * _ROW + _GAP) + 46
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height}" {_FONT}>',
        "<title>Times to a new mode, over the documented waits</title>",
        f'<rect width="{_WIDTH}" height="{height}" fill="white"/>',
        *_axis(height),
        *_legend(measured),
    ]
    top = _TOP
    for name, event in EVENTS.items():
        lines += _label(event, top, len(measured) * _ROW)
        for index, samples in enumerate(measured.values()):
            lines += _dots(event, samples[name], top + index * _ROW, _COLOURS[index % len(_COLOURS)])
        top += len(measured) * _ROW + _GAP
    return "\n".join([*lines, "</svg>"]) + "\n"


def _whole_s(event: Event) -> float:
    """The documented waits: what is counted, with the one before the first frame in question where that is a miss."""
    if event.deadline_s is None:
        return 0.0
    return event.deadline_s if event is not EVENTS["commands"] else event.deadline_s / 9 * 10


def _x(over_ms: float) -> float:
    return _LEFT + (over_ms - _FIRST_MS) / (_LAST_MS - _FIRST_MS) * (_WIDTH - _LEFT - _RIGHT)


def _axis(height: int) -> Iterable[str]:
    for ms in range(0, _LAST_MS + 1, 10):
        yield f'<line x1="{_x(ms):.1f}" x2="{_x(ms):.1f}" y1="{_TOP}" y2="{height - 44}" stroke="#dddddd"/>'
        yield f'<text x="{_x(ms):.1f}" y="{height - 28}" text-anchor="middle">{ms}</text>'
    middle = (_x(0) + _x(_LAST_MS)) / 2
    yield f'<text x="{middle:.1f}" y="{height - 8}" text-anchor="middle">seen, ms beyond the documented waits</text>'


def _legend(measured: Mapping[str, Samples]) -> Iterable[str]:
    x = float(_LEFT)
    for index, board in enumerate(measured):
        yield f'<circle cx="{x:.1f}" cy="18" r="4" fill="{_COLOURS[index % len(_COLOURS)]}"/>'
        yield f'<text x="{x + 8:.1f}" y="22">{escape(board)}</text>'
        x += 40 + 6.5 * len(board)


def _label(event: Event, top: float, height: float) -> Iterable[str]:
    what, _, to = event.name.partition(", ")
    middle = top + height / 2
    yield f'<text x="{_LEFT - 10}" y="{middle - 3:.1f}" text-anchor="end">{escape(what)}</text>'
    waits = f"{to}: {_ms(_whole_s(event))} ms" if event.deadline_s is not None else to
    yield f'<text x="{_LEFT - 10}" y="{middle + 12:.1f}" text-anchor="end" fill="#555555">{escape(waits)}</text>'
    least, most = (_x((s - _whole_s(event)) * 1e3) for s in (event.seen_least_s, event.seen_most_s))
    yield (
        f'<rect x="{least - 2:.1f}" y="{top:.1f}" width="{most - least + 4:.1f}" height="{height:.1f}" fill="#eeeeee"/>'
    )


def _dots(event: Event, samples: Sequence[Sample], top: float, colour: str) -> Iterable[str]:
    for index, sample in enumerate(samples):
        x = _x((sample.seen_s - _whole_s(event)) * 1e3)
        y = top + 4 + (index * 7 % 18)
        yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2" fill="{colour}" fill-opacity="0.6"/>'
