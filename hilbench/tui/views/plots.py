"""Signals over time in Braille dots: one below the other, each filled, with a scale and a unit of its own."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence

from rich.text import Text

from hilbench.tui.model.signals import Signal, SignalsModel
from hilbench.tui.views.canvas import Canvas
from hilbench.tui.views.words import DIM, HEAD, fit, tail

__all__ = ["SPANS_S", "figure", "plots_view"]

_LEAST_SPAN_S = 2
SPANS_S = (_LEAST_SPAN_S, 5, 10, 20, 60, 120, 300)
NS_PER_S = 1_000_000_000
_LEAST_ROWS = 3
_LEAST_NAME = 12
"""Cells that the name of a signal keeps in little room (choice)."""
_GUTTER = 9
_COLOURS = ("cyan", "green", "yellow", "magenta")
_APART_NS = 1_500_000_000
"""Points further apart than this are not joined: nobody said what was between them (choice)."""
_MOST = sys.float_info.max
_ALL = 100.0
_NEAR_0, _LEAST_SHARE, _STEPS, _LITTLE = 0.8, 0.1, 4, 0.02
"""Of a scale: when 0 is near enough to be on it, how narrow it may be beside its values, how many round steps it has at
least, and the share of a step that may be cut off (choices)."""
_ROUNDED, _HAIR = 1e15, 1e-9
Place = tuple[float, float]
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
    there = {name: signals.signal(name) for name in (signals.usual() if chosen is None else chosen)}
    found = [(name, signal) for name, signal in there.items() if signal is not None]
    if not found:
        hint = "no figure is recorded yet" if not signals.signals else "none chosen: L chooses"
        return [fit(Text(hint, DIM), width)]
    room = max(1, (height - 1) // _LEAST_ROWS)
    left_out, found = found[room:], found[:room]
    lines: list[Text] = []
    for number, (name, signal) in enumerate(found):
        rows = (height - 1) * (number + 1) // len(found) - (height - 1) * number // len(found)
        lines += _lane(name, signal, width, max(2, rows), now_ns, span_s, number)
    return [*lines, fit(_axis(width, span_s, len(left_out)), width)]


def _lane(name: str, signal: Signal, width: int, rows: int, now_ns: int, span_s: int, number: int) -> list[Text]:
    begin_ns = now_ns - span_s * NS_PER_S
    parts = signal.since(begin_ns)
    inside = [[value for ns, value in points if begin_ns <= ns <= now_ns] for points in parts]
    styles = [_COLOURS[(number + part) % len(_COLOURS)] for part in range(len(parts))]
    said = Text()
    shown = [value for values in inside for value in values]
    if not shown:
        said.append("nothing in this time", DIM)
        return [_head(name, said, width), *(Text("") for _ in range(rows - 1))]
    for values, style in zip(inside, styles, strict=True):
        said.append(f"{figure(values[-1]) if values else '-'} ", f"bold {style}")
    said.append(f"{signal.unit}   {figure(min(shown))} to {figure(max(shown))}", DIM)
    scale = bottom, top = _scale(min(shown), max(shown), signal.unit, filled=len(parts) == 1)
    canvas = Canvas(max(1, width - _GUTTER), rows - 1)
    for points, style in zip(parts, styles, strict=True):
        pieces = list(_pieces(canvas, points, begin_ns, now_ns, scale))
        if len(parts) == 1:  # one filled over the other would hide it
            _fill(canvas, pieces, _height_of(canvas, max(bottom, min(top, 0.0)), scale), f"dim {style}")
        for begin, end in pieces:
            canvas.line(begin, end, style)
    labels = _labels(bottom, top, rows)
    drawn = [
        Text.assemble((f"{labels.get(row, ''):>{_GUTTER - 2}} ", DIM), ("┤" if row in labels else "│", DIM), line)
        for row, line in enumerate(canvas.lines())
    ]
    return [_head(name, said, width), *(fit(line, width) for line in drawn)]


def _head(name: str, said: Text, width: int) -> Text:
    """Return the name of a signal and what is said of it; a name that is too long gives way."""
    room = max(_LEAST_NAME, width - said.cell_len - 1)
    return fit(Text.assemble((f"{tail(name, room)} ", HEAD), said), width)


def _pieces(
    canvas: Canvas, points: Sequence[tuple[int, float]], begin_ns: int, end_ns: int, scale: tuple[float, float]
) -> Iterator[tuple[Place, Place]]:
    """Yield the lines between points that belong together; a point that stands alone is a line to itself."""
    before: tuple[int, Place] | None = None
    for ns, value in points:
        if ns > end_ns:
            break
        x = (ns - begin_ns) / (end_ns - begin_ns) * (canvas.width - 1)
        place = (x, _height_of(canvas, value, scale))
        joins = before is not None and ns - before[0] <= _APART_NS
        yield (before[1] if before is not None and joins else place), place
        before = (ns, place)


def _height_of(canvas: Canvas, value: float, scale: tuple[float, float]) -> float:
    """Return how far below the upper edge a value is, in dots."""
    bottom, top = scale
    y = (top / 2 - value / 2) / (top / 2 - bottom / 2) * (canvas.height - 1)  # the largest figures have no double
    return min(max(y, 0.0), canvas.height - 1.0)


def _fill(canvas: Canvas, pieces: Sequence[tuple[Place, Place]], floor: float, style: str) -> None:
    """Fill what lies between lines and the value 0, or the end of the scale that is nearest to it."""
    for (x0, y0), (x1, y1) in pieces:
        for x in range(max(0, math.ceil(x0)), math.floor(x1) + 1):
            canvas.column(x, y0 + (y1 - y0) * (x - x0) / max(1.0, x1 - x0), floor, style)


def _scale(low: float, high: float, unit: str, *, filled: bool) -> tuple[float, float]:
    """Return the ends of the scale.

    A share goes from 0 to all of it, either way if need be. Anything else has round figures around its values, with 0
    where that is near or what is filled reaches to it; the scale is never so narrow that noise fills it.
    """
    if unit == "%" and low >= -_ALL and high <= _ALL:
        return (0.0 if low >= 0 else -_ALL), _ALL
    if low > 0 and (filled or low < _NEAR_0 * high):
        low = 0.0
    if high < 0 and (filled or high > _NEAR_0 * low):
        high = 0.0
    if low == high == 0:
        return 0.0, 1.0
    least = max(abs(low), abs(high)) * _LEAST_SHARE
    if high - low < least:
        middle = low / 2 + high / 2
        low, high = middle - least / 2, middle + least / 2
    if max(abs(low), abs(high)) < _ROUNDED and high - low > _HAIR:
        step = _step((high - low) / _STEPS)
        low, high = math.floor(low / step + _LITTLE) * step, math.ceil(high / step - _LITTLE) * step
    return max(low, -_MOST), min(high, _MOST)


def _step(least: float) -> float:
    """Return the least round figure that is no less: 1, 2 or 5, and any number of zeros."""
    ten = 10.0 ** math.floor(math.log10(least))
    return next(times * ten for times in (1, 2, 5, 10) if times * ten >= least * (1 - _HAIR))


def _labels(bottom: float, top: float, rows: int) -> dict[int, str]:
    """Return the figures beside the rows of a lane: its ends, and 0 where it lies between them."""
    last = rows - 2
    if last < 1:
        return {0: figure(bottom)}
    labels = {0: figure(top), last: figure(bottom)}
    if bottom < 0 < top:
        labels.setdefault(round(last * (top / 2 / (top / 2 - bottom / 2))), "0")
    return labels


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
