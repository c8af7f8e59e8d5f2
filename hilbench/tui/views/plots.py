"""Signals over time in Braille dots: one below the other, each with a scale and a unit of its own."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence

from rich.text import Text

from hilbench.tui.model.signals import Signal, SignalsModel
from hilbench.tui.views.canvas import Canvas
from hilbench.tui.views.words import DIM, HEAD, fit

__all__ = ["SPANS_S", "figure", "plots_view"]

_LEAST_SPAN_S = 2
SPANS_S = (_LEAST_SPAN_S, 5, 10, 20, 60, 120, 300)
NS_PER_S = 1_000_000_000
_LEAST_ROWS = 3
_GUTTER = 9
_COLOURS = ("cyan", "green", "yellow", "magenta")
_APART_NS = 1_500_000_000
"""Points further apart than this are not joined: nobody said what was between them (choice)."""
_MOST = sys.float_info.max
_BIG, _SMALL, _SMALLEST = 100.0, 10.0, 0.005


def plots_view(
    signals: SignalsModel,
    width: int,
    height: int,
    now_ns: int,
    *,
    chosen: Sequence[str] | None = None,
    span_s: int = 20,
) -> list[Text]:
    """Return plots of the chosen signals, of the usual ones if none were chosen.

    They go over so many seconds up to now, or since the bench began where that is less.
    """
    span_s = max(_LEAST_SPAN_S, min(span_s, math.ceil(now_ns / NS_PER_S)))
    names = [name for name in (signals.usual() if chosen is None else chosen) if name in signals.signals]
    if not names:
        hint = "no figure is recorded yet" if not signals.signals else "none chosen: L chooses"
        return [fit(Text(hint, DIM), width)]
    room = max(1, (height - 1) // _LEAST_ROWS)
    left_out, names = names[room:], names[:room]
    lines: list[Text] = []
    for number, name in enumerate(names):
        rows = (height - 1) * (number + 1) // len(names) - (height - 1) * number // len(names)
        lines += _lane(name, signals.signals[name], width, max(2, rows), now_ns, span_s, number)
    return [*lines, fit(_axis(width, span_s, len(left_out)), width)]


def _lane(name: str, signal: Signal, width: int, rows: int, now_ns: int, span_s: int, number: int) -> list[Text]:
    begin_ns = now_ns - span_s * NS_PER_S
    parts = signal.since(begin_ns)
    inside = [[value for ns, value in points if begin_ns <= ns <= now_ns] for points in parts]
    styles = [_COLOURS[(number + part) % len(_COLOURS)] for part in range(len(parts))]
    head = Text.assemble((f"{name} ", HEAD))
    shown = [value for values in inside for value in values]
    if not shown:
        head.append("nothing in this time", DIM)
        return [fit(head, width), *(Text("") for _ in range(rows - 1))]
    for values, style in zip(inside, styles, strict=True):
        head.append(f"{figure(values[-1]) if values else '-'} ", f"bold {style}")
    head.append(f"{signal.unit}   {figure(min(shown))} to {figure(max(shown))}", DIM)
    bottom, top = _scale(min(shown), max(shown))
    canvas = Canvas(max(1, width - _GUTTER), rows - 1)
    for points, style in zip(parts, styles, strict=True):
        _draw(canvas, points, begin_ns, now_ns, (bottom, top), style)
    labels = {0: figure(top), rows - 2: figure(bottom)} if rows > 2 else {0: figure(bottom)}
    drawn = [
        Text.assemble((f"{labels.get(row, ''):>{_GUTTER - 2}} ", DIM), ("┤" if row in labels else "│", DIM), line)
        for row, line in enumerate(canvas.lines())
    ]
    return [fit(line, width) for line in (head, *drawn)]


def _draw(
    canvas: Canvas,
    points: Sequence[tuple[int, float]],
    begin_ns: int,
    end_ns: int,
    scale: tuple[float, float],
    style: str,
) -> None:
    bottom, top = scale
    before: tuple[int, tuple[float, float]] | None = None
    for ns, value in points:
        if ns > end_ns:
            break
        x = (ns - begin_ns) / (end_ns - begin_ns) * (canvas.width - 1)
        y = (top / 2 - value / 2) / (top / 2 - bottom / 2) * (canvas.height - 1)  # the largest figures have no double
        place = (x, min(max(y, 0.0), canvas.height - 1.0))
        if before is not None and ns - before[0] <= _APART_NS:
            canvas.line(before[1], place, style)
        else:
            canvas.dot(*place, style)
        before = (ns, place)


def _scale(low: float, high: float) -> tuple[float, float]:
    """Return the ends of the scale: those of the values, with 0 where that is near, never closer than can be told."""
    if low > 0 and low < 0.5 * high:
        low = 0.0
    if high < 0 and high > 0.5 * low:
        high = 0.0
    least = max(abs(low), abs(high)) * 0.02 or 1.0
    if high - low < least:
        middle = low / 2 + high / 2
        low, high = (max(min(end, _MOST), -_MOST) for end in (middle - least / 2, middle + least / 2))
    return low, high


def _axis(width: int, span_s: int, left_out: int) -> Text:
    room = width - _GUTTER
    begin, end = f"-{span_s} s", "now"
    middle = f"-{span_s / 2:g} s" if room > 40 else ""
    line = begin + middle.center(max(1, room - len(begin) - len(end))) + end
    more = f" {left_out} more" if left_out else ""
    return Text.assemble((f"{more:<{_GUTTER}}", HEAD), (line, DIM))


def figure(value: float) -> str:
    """Return a value in few letters."""
    size = abs(value)
    if size < _SMALLEST:
        return "0.00"
    if size >= _BIG * _BIG * _BIG:
        return f"{value:.1e}"
    if size >= _BIG:
        return f"{value:.0f}"
    return f"{value:.1f}" if size >= _SMALL else f"{value:.2f}"
