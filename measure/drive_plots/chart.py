"""A plain chart as SVG, written by hand: lines over a common x axis, one panel below the other."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape

__all__ = ["Panel", "chart"]

Point = tuple[float, float]

WIDTH, LEFT, RIGHT, TOP, BOTTOM = 760, 64, 16, 30, 46
PANEL, GAP = 130, 34
LEAST_STEP_PX = 0.8
FONT = 'font-family="sans-serif" font-size="12"'


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """One panel.

    Attributes:
        title: what is drawn, with its unit.
        low: the lower end of its axis.
        high: the upper end.
        step: between two lines of its grid.
        lines: x and y of each line, with its colour.
        band: y between which it should stay, shaded; None without.
    """

    title: str
    low: float
    high: float
    step: float
    lines: Sequence[tuple[Sequence[Point], str]]
    band: tuple[float, float] | None = None


def chart(title: str, x_title: str, x_ticks: Sequence[float], panels: Sequence[Panel]) -> str:
    """Return the picture."""
    height = TOP + len(panels) * (PANEL + GAP) - GAP + BOTTOM
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" {FONT}>',
        f"<title>{escape(title)}</title>",
        f'<rect width="{WIDTH}" height="{height}" fill="white"/>',
    ]
    for index, panel in enumerate(panels):
        lines += _panel(panel, TOP + index * (PANEL + GAP), x_ticks)
    lines += [
        f'<text x="{_x(x, x_ticks):.1f}" y="{height - BOTTOM + 18}" text-anchor="middle">{x:g}</text>' for x in x_ticks
    ]
    middle = (LEFT + WIDTH - RIGHT) / 2
    lines += [f'<text x="{middle:.1f}" y="{height - 8}" text-anchor="middle">{escape(x_title)}</text>', "</svg>"]
    return "\n".join(lines) + "\n"


def _x(x: float, ticks: Sequence[float]) -> float:
    return LEFT + (x - ticks[0]) / (ticks[-1] - ticks[0]) * (WIDTH - LEFT - RIGHT)


def _panel(panel: Panel, top: float, ticks: Sequence[float]) -> Iterable[str]:
    def y(value: float) -> float:
        return top + (panel.high - value) / (panel.high - panel.low) * PANEL

    if panel.band is not None:
        low, high = panel.band
        yield f'<rect x="{LEFT}" y="{y(high):.1f}" width="{WIDTH - LEFT - RIGHT}" height="{y(low) - y(high):.1f}" '
        yield 'fill="#eef5ee"/>'
    for tick in ticks:
        x = _x(tick, ticks)
        yield f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{top}" y2="{top + PANEL}" stroke="#eeeeee"/>'
    for number in range(round((panel.high - panel.low) / panel.step) + 1):
        value = panel.low + number * panel.step
        yield f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y(value):.1f}" y2="{y(value):.1f}" stroke="#dddddd"/>'
        yield f'<text x="{LEFT - 6}" y="{y(value) + 4:.1f}" text-anchor="end">{value:g}</text>'
    yield f'<text x="{LEFT}" y="{top - 8}">{escape(panel.title)}</text>'
    for points, colour in panel.lines:
        drawn = " ".join(f"{px:.1f},{py:.1f}" for px, py in _thinned([(_x(a, ticks), y(b)) for a, b in points]))
        yield f'<polyline points="{drawn}" fill="none" stroke="{colour}" stroke-width="1.6"/>'


def _thinned(points: Sequence[Point]) -> list[Point]:
    """Leave out what is nearer to the point before than can be seen."""
    kept = [points[0]]
    for x, y in points[1:]:
        if abs(x - kept[-1][0]) + abs(y - kept[-1][1]) >= LEAST_STEP_PX:
            kept.append((x, y))
    return kept
