"""Frames as rows: an answer joined to its request, and equal ones in a row folded into one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from hilbench.tui.model.frames import FrameModel

__all__ = ["FrameRow", "rows_of"]

_ANSWERED_WITHIN_NS = 2_000_000_000
"""What comes later is no answer (choice)."""


@dataclass(slots=True, eq=False)
class FrameRow:
    """A row.

    Attributes:
        frame: the latest of its frames.
        request: what that answers; None if it answers nothing.
        since_ns: how long the frame before it, of any row, was ago; None of the first one.
        frames: all of its frames and of their requests, the oldest first.
        count: how many frames of the row are like the latest.
    """

    frame: FrameModel
    request: FrameModel | None
    since_ns: int | None
    frames: list[FrameModel]
    count: int = 1

    @property
    def number(self) -> int:
        """The number of its latest frame."""
        return self.frame.number

    def takes(self, other: FrameRow) -> bool:
        """Return whether another row says the same: the same message, in answer to the same request."""
        return (
            self.frame.good == other.frame.good
            and self.frame.message == other.frame.message
            and _name(self.request) == _name(other.request)
        )


def rows_of(frames: Sequence[FrameModel], *, fold: bool = True) -> list[FrameRow]:
    """Return frames in rows, the oldest first.

    Args:
        frames: in the order in which they came.
        fold: whether equal ones in a row are one.
    """
    rows: list[FrameRow] = []
    for row in _joined(frames):
        if fold and rows and rows[-1].takes(row):
            last = rows[-1]
            last.frame, last.request, last.since_ns = row.frame, row.request, row.since_ns
            last.frames += row.frames
            last.count += 1
        else:
            rows.append(row)
    return rows


def _joined(frames: Iterable[FrameModel]) -> list[FrameRow]:
    """Return a row for each frame, but none for a request that is answered: it stands in the row of its answer.

    An answer is that to the latest request: the ones before were lost.
    """
    rows: list[FrameRow] = []
    open_rows: list[FrameRow] = []
    before: FrameModel | None = None
    for frame in frames:
        open_rows = [row for row in open_rows if frame.ns - row.frame.ns <= _ANSWERED_WITHIN_NS]
        asked = next((row for row in reversed(open_rows) if frame.answers(row.frame)), None)
        since_ns = None if before is None else frame.ns - before.ns
        row = FrameRow(frame, None, since_ns, [frame])
        if asked is not None:
            open_rows = [row for row in open_rows if row.frame.message != asked.frame.message]
            rows.remove(asked)
            row.request, row.frames = asked.frame, [asked.frame, frame]
        if frame.asks:
            open_rows.append(row)
        rows.append(row)
        before = frame
    return rows


def _name(frame: FrameModel | None) -> str:
    return "" if frame is None else frame.item.name
