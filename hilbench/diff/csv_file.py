"""Reads what logic analysers export: a column of times, and one column of levels for each pin.

The first line names the columns. Times are in seconds, or in the unit that the name of their column ends with. A line
stands for a sample or for a change, whichever the program writes; commas, semicolons or tabs separate. A level is 0 or
1; ``z``, ``x`` or nothing is a wire that floats.
"""

from __future__ import annotations

import csv
import decimal
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from hilbench.clock import NS_PER_S
from hilbench.diff.capture import END_NS, Capture, Track
from hilbench.errors import UnavailableError

__all__ = ["read_csv"]

_LEVELS: dict[str, bool | None] = {"0": False, "1": True, "": None, "z": None, "x": None}
_COMMENTS = (";", "#")

_TIME = re.compile(r"time(?:stamp)?(?:[\s_]*[\s_(\[]\s*(?P<unit>[^\W_]+)\s*[)\]]?)?", re.IGNORECASE)
_UNITS = {"s": "seconds", "ms": "milliseconds", "us": "microseconds", "ns": "nanoseconds", "ps": "picoseconds"}
_NS = {
    "seconds": decimal.Decimal(NS_PER_S),
    "milliseconds": decimal.Decimal(10**6),
    "microseconds": decimal.Decimal(10**3),
    "nanoseconds": decimal.Decimal(1),
    "picoseconds": decimal.Decimal("0.001"),
}
_MICRO = str.maketrans("\u00b5\u03bc", "uu")

Row = tuple[int, list[bool | None]]


def read_csv(path: Path) -> Capture:
    """Read a file.

    Raises:
        UnavailableError: it cannot be read, or is no such table; the line is named.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").split("\n")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is no text"
        raise UnavailableError(f"cannot be read: {reason}", where=str(path)) from error
    try:
        head, rows, remarks = _table(path, lines)
        tracks, end_ns = _tracks(path, head, rows)
    except csv.Error as error:
        raise UnavailableError(f"is no table: {error}", where=str(path)) from error
    return Capture(
        label=str(path),
        kind="table of samples",
        tracks={track.name: track for track in tracks},
        end_ns=end_ns,
        floats=any(None in track.values or track.initial is None for track in tracks),
        remarks=remarks,
    )


def _table(path: Path, lines: Sequence[str]) -> tuple[list[str], Iterator[Row], tuple[str, ...]]:
    """Return the names of the columns, what stands below them, and what is to be said of the end."""
    start = next((at for at, line in enumerate(lines) if line.strip() and not line.startswith(_COMMENTS)), None)
    if start is None:
        raise UnavailableError("is empty", where=str(path))
    delimiter = max(",;\t", key=lines[start].count)
    head = [cell.strip() for cell in next(csv.reader([lines[start]], delimiter=delimiter))]
    if len(head) < 2 or not head[0].lower().startswith("time"):
        hint = "the first line of a table names the columns, 'Time [s]' first, then one for each pin"
        raise UnavailableError("is neither a journal, nor waveforms (VCD), nor a table", where=str(path), hint=hint)
    twice = next((name for name in head if head.count(name) > 1), None)
    if twice is not None:
        raise UnavailableError(f"has two columns '{twice}'", where=f"{path}:{start + 1}")
    unit = _unit(head[0], f"{path}:{start + 1}")
    whole, remarks = _without_torn_line(lines[start + 1 :], delimiter, len(head))
    return head, _rows(path, whole, start + 2, delimiter, len(head), unit), remarks


def _without_torn_line(lines: Sequence[str], delimiter: str, columns: int) -> tuple[Sequence[str], tuple[str, ...]]:
    """Return lines without a last one that was cut, and what is to be said of it.

    Many programs leave the end of the last line away. A level is one letter, so a line with a level in its last column
    says all that it ever said; one that ends with an empty cell may have been cut before the level.
    """
    if not lines or not lines[-1].strip():
        return lines[:-1], ()
    cells = next(csv.reader(lines[-1:], delimiter=delimiter))
    if len(cells) < columns or not cells[-1].strip():
        return lines[:-1], ("its last line has no end and is left out",)
    return lines, ("its last line has no end: whether more lines followed cannot be known",)


def _unit(name: str, where: str) -> str:
    """Return the unit that the name of the column of times tells, such as ``milliseconds``."""
    match = _TIME.fullmatch(name)
    named = (match["unit"] or "s").lower().translate(_MICRO) if match else ""
    unit = _UNITS.get(named, named)
    if unit not in _NS:
        hint = f"call it 'Time [s]', or with one of the units {', '.join(_UNITS)}"
        raise UnavailableError(f"'{name}' has no unit that is known", where=where, hint=hint)
    return unit


def _rows(path: Path, lines: Sequence[str], first: int, delimiter: str, columns: int, unit: str) -> Iterator[Row]:
    last_ns = None
    for number, cells in enumerate(csv.reader(lines, delimiter=delimiter), first):
        if not cells:
            continue
        where = f"{path}:{number}"
        if len(cells) != columns:
            raise UnavailableError(f"has {len(cells)} columns instead of {columns}", where=where)
        ns = _ns(cells[0], unit, where)
        if last_ns is not None and ns < last_ns:
            symbol = next(symbol for symbol, name in _UNITS.items() if name == unit)
            raise UnavailableError(f"its time goes back to {cells[0].strip()} {symbol}", where=where)
        last_ns = ns
        yield ns, [_level(cell, where) for cell in cells[1:]]


def _ns(text: str, unit: str, where: str) -> int:
    try:
        exact = decimal.Decimal(text.strip()) * _NS[unit]
        if abs(exact) < END_NS:
            return round(exact)
    except (decimal.DecimalException, ValueError):
        pass
    raise UnavailableError(f"'{text.strip()}' is no time in {unit}", where=where)


def _level(text: str, where: str) -> bool | None:
    try:
        return _LEVELS[text.strip().lower()]
    except KeyError as error:
        raise UnavailableError(f"'{text.strip()}' is no level: 0, 1 or z", where=where) from error


def _tracks(path: Path, head: list[str], rows: Iterator[Row]) -> tuple[list[Track], int]:
    initial: list[bool | None] = []
    levels: list[bool | None] = []
    edges: list[list[tuple[int, bool | None]]] = [[] for _ in head[1:]]
    end_ns = 0
    for end_ns, now in rows:
        if not levels:
            initial = levels = now
        for column, level in enumerate(now):
            if level is not levels[column]:
                edges[column].append((end_ns, level))
        levels = now
    if not initial:
        raise UnavailableError("has no samples", where=str(path))
    tracks = [
        Track(
            name=name,
            times_ns=[ns for ns, _ in edges[column]],
            values=[level for _, level in edges[column]],
            initial=initial[column],
            initial_known=True,
        )
        for column, name in enumerate(head[1:])
    ]
    return tracks, end_ns
