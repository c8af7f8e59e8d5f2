"""The frames as a table, and one of them byte by byte."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from typing import TYPE_CHECKING

from rich.text import Text

from hilbench.tui.model.frames import FrameModel
from hilbench.tui.views.words import BAD, DIM, HEAD, LIT, fit, seconds
from protocols.common.item_words import value_text

if TYPE_CHECKING:
    from protocols.common.layout import Region

__all__ = ["frame_line", "frame_view", "frames_view"]

_BYTE_STYLES = ("cyan", "yellow", "green", "magenta")


def frames_view(
    frames: Sequence[FrameModel], width: int, height: int, *, chosen: int | None = None, empty: str = "no frame yet"
) -> list[Text]:
    """Return the latest frames, the newest at the bottom; `chosen` is the number of the one that is pointed at."""
    lines = [frame_line(frame, width, chosen=frame.number == chosen) for frame in frames[-height:]]
    return lines or [Text(empty, DIM)]


def frame_line(frame: FrameModel, width: int, *, chosen: bool = False) -> Text:
    """Return a frame in one line."""
    line = Text.assemble(
        ("▸" if chosen else " ", HEAD),
        (f"{seconds(frame.ns):>12} ", DIM),
        (f"{frame.line:<10}" if frame.line else "", DIM),
        ("> " if frame.sent else "< ", "cyan" if frame.sent else "yellow"),
        (frame.text, "" if frame.good else BAD),
    )
    line = fit(line, width)
    if chosen:
        line.stylize(LIT)
    return line


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
    value = frame.item.fields.get(region.name)
    shown = region.data[:8].hex(" ").upper() + (" ..." if len(region.data) > 8 else "")
    span = f"{region.start}" if len(region.data) == 1 else f"{region.start}-{region.start + len(region.data) - 1}"
    said = "" if value is None else f" = {value_text(value)}"
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
