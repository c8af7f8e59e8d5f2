"""The frames as a table, and one of them byte by byte."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import Enum
from itertools import cycle
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from rich.text import Text

from hilbench.tui.model.frames import FrameModel
from hilbench.tui.model.rows import FrameRow
from hilbench.tui.views.words import BAD, DIM, HEAD, LIT, fit, ns_words, seconds
from protocols.common.item_words import value_text

if TYPE_CHECKING:
    from protocols.common.layout import Region

__all__ = ["fields_text", "frame_view", "frames_view"]

_WITH_SINCE = 50
"""With fewer columns there is no room for how long the frame before was ago (choice)."""
_SHOWN_BYTES = 24
_WIDEST = 12
"""A field of no more letters than this is a column (choice)."""
_BYTE_STYLES = ("cyan", "yellow", "green", "magenta")


def frames_view(
    rows: Sequence[FrameRow], width: int, height: int, *, chosen: int | None = None, empty: str = "no frame yet"
) -> list[Text]:
    """Return the latest rows in columns, the newest at the bottom.

    Args:
        rows: of frames.
        width: cells in a line.
        height: lines there are.
        chosen: the number of the frame that is pointed at.
        empty: what is said if there is none.
    """
    shown = rows[-height:]
    if not shown:
        return [Text(empty, DIM)]
    columns = _Columns(
        time=max(len(seconds(row.frame.ns)) for row in shown),
        since=max(len(_since(row)) for row in shown) if width >= _WITH_SINCE else 0,
        line=max(len(row.frame.line) for row in shown),
        name=min(max(len(_name(row.frame)) for row in shown), max(8, width // 3)),
        times=max(len(_count(row)) for row in shown),
        fields=_breadths(shown),
    )
    return [_row_line(row, columns, width, chosen=row.number == chosen) for row in shown]


Breadths = Mapping[tuple[str, bool, str, str], int]


class _Columns(NamedTuple):
    """How wide the columns are, in cells; those of the fields by message and field."""

    time: int
    since: int
    line: int
    name: int
    times: int
    fields: Breadths


def _breadths(shown: Sequence[FrameRow]) -> Breadths:
    """Return how wide each field of each message is; a long one stands as it is, and those behind it move."""
    breadths: dict[tuple[str, bool, str, str], int] = {}
    for frame in (row.frame for row in shown if row.frame.good):
        for one in frame.fields:
            if len(one.text) <= _WIDEST:
                key = *frame.message, one.name
                breadths[key] = max(breadths.get(key, 0), len(one.text))
    return breadths


def _row_line(row: FrameRow, columns: _Columns, width: int, *, chosen: bool) -> Text:
    frame = row.frame
    way, style = ("⇄", "magenta") if row.request is not None else (">", "cyan") if frame.sent else ("<", "yellow")
    name = _name(frame)
    if len(name) > columns.name:
        name = f"{name[: columns.name - 1]}…"
    line = Text.assemble(
        ("▸" if chosen else " ", HEAD),
        (f"{seconds(frame.ns):>{columns.time}} ", ""),
        (f"{_since(row):>{columns.since}} " if columns.since else "", DIM),
        (f"{frame.line:<{columns.line}} " if columns.line else "", DIM),
        (f"{way} ", style),
        (f"{name:<{columns.name}}", HEAD if frame.good else f"{BAD} reverse"),
        " ",
        (f"{_count(row):<{columns.times}} " if columns.times else "", "yellow"),
        _answer(row),
        fields_text(frame, columns.fields),
    )
    line = fit(line, width)
    if chosen:
        line = Text(f"{line.plain:<{width}}", LIT)
    return line


def _name(frame: FrameModel) -> str:
    return frame.item.name if frame.good else f"!! {frame.item.name}"


def _count(row: FrameRow) -> str:
    return f"x{row.count}" if row.count > 1 else ""


def _since(row: FrameRow) -> str:
    return "" if row.since_ns is None else f"+{ns_words(row.since_ns)}"


def _answer(row: FrameRow) -> Text:
    if row.request is None:
        return Text("")
    after = ns_words(row.frame.ns - row.request.ns)
    asked = " ".join([row.request.item.name, *(one.text for one in row.request.fields)])
    return Text.assemble(("to ", DIM), asked, (f" in {after}  ", DIM))


def fields_text(frame: FrameModel, breadths: Breadths = MappingProxyType({})) -> Text:
    """Return what a frame says, field by field with their units; its bytes if it is not sound.

    Args:
        frame: which.
        breadths: how many cells each field has, where they stand one below the other.
    """
    if not frame.good:
        return Text(frame.item.raw[:_SHOWN_BYTES].hex(" ").upper(), BAD)
    said = Text()
    for one in frame.fields:
        said.append(f"{one.quantity.label} ", DIM)
        breadth = breadths.get((*frame.message, one.name), 0)
        number = isinstance(one.value, int | float) and not isinstance(one.value, bool | Enum)
        said.append(f"{one.text:>{breadth}}" if number else f"{one.text:<{breadth}}")
        said.append(f" {one.quantity.unit}  " if one.quantity.unit else "  ", DIM)
    return said


def frame_view(frame: FrameModel, width: int) -> list[Text]:
    """Return a frame whole: its bytes, each field's in brackets of their own, and what each field says."""
    way = "sent" if frame.sent else "heard"
    head = Text.assemble((frame.item.name, HEAD), f"  {way} at {seconds(frame.ns)}, {len(frame.item.raw)} bytes")
    if not frame.good:
        return [fit(head, width), *_wrapped([Text(frame.item.raw.hex(" ").upper(), BAD)], width)]
    found = frame.regions
    styled = [*zip(found, cycle(_BYTE_STYLES), strict=False)]
    pieces = [Text(f"[{region.data.hex(' ').upper()}]", style) for region, style in styled]
    table = [_row(region, frame, style, width) for region, style in styled]
    return [fit(head, width), *_wrapped(pieces, width), Text(""), *table]


def _row(region: Region, frame: FrameModel, style: str, width: int) -> Text:
    found = next((one for one in frame.fields if one.name == region.name), None)
    shown = region.data[:8].hex(" ").upper() + (" ..." if len(region.data) > 8 else "")
    span = f"{region.start}" if len(region.data) == 1 else f"{region.start}-{region.start + len(region.data) - 1}"
    said = "" if found is None else f" = {value_text(found.value)}"
    if found is not None and found.quantity.unit:
        said += f" is {found.text}" if found.quantity.scale != 1 else ""
        said += f" {found.quantity.unit}"
    return fit(Text.assemble((f"{span:>7}  ", DIM), (f"{region.name:<19}", style), f" {shown:<27}", said), width)


def _wrapped(pieces: Sequence[Text], width: int) -> list[Text]:
    """Return pieces in lines, broken between bytes."""
    words: list[Text] = []
    for piece in pieces:
        words += piece.split(" ")
    lines, line = [], Text()
    for word in words:
        glue = "" if not line or (line.plain.endswith("]") and word.plain.startswith("[")) else " "
        if line and line.cell_len + len(glue) + word.cell_len > width:
            lines.append(line)
            line, glue = Text(), ""
        line = Text.assemble(line, glue, word)
    return [*lines, line]
