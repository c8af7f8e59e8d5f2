"""A recording as one line: the place in it, and where something happened."""

from __future__ import annotations

from collections.abc import Sequence

from rich.text import Text

from hilbench.tui.views.words import BAD, DIM, HEAD, seconds

__all__ = ["MARKS", "time_at", "timeline_view"]

MARKS = {"!": BAD, "m": "bold cyan", "c": "bold green"}
"""What stands on the line: an error, a mark, a verdict; where several fall into one cell, the first of these."""
_EDGE = 13


def timeline_view(length_ns: int, now_ns: int, marks: Sequence[tuple[int, str]], width: int) -> Text:
    """Return the line; what was before the place is drawn thick."""
    room = max(1, width - 2 * _EDGE)
    cells: dict[int, str] = {}
    order = list(MARKS)
    for ns, mark in marks:
        at = _cell(ns, length_ns, room)
        if at not in cells or order.index(mark) < order.index(cells[at]):
            cells[at] = mark
    here = _cell(now_ns, length_ns, room)
    line = Text.assemble((f"{seconds(now_ns):>{_EDGE - 1}} ", HEAD))
    for at in range(room):
        if at == here:
            line.append("●", HEAD)
        elif at in cells:
            line.append(cells[at], MARKS[cells[at]])
        else:
            line.append("━" if at < here else "─", "" if at < here else DIM)
    line.append(f" {seconds(length_ns)}", DIM)
    line.no_wrap = True
    return line


def time_at(column: int, length_ns: int, width: int) -> int:
    """Return the bench time that a column of the line stands for."""
    room = max(1, width - 2 * _EDGE)
    return round(length_ns * max(0.0, min(1.0, (column - _EDGE) / max(1, room - 1))))


def _cell(ns: int, length_ns: int, room: int) -> int:
    return min(room - 1, round(ns / max(1, length_ns) * (room - 1)))
