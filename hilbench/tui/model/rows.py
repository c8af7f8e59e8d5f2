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

    An answer is that to the request with most of the same fields, such as a number; where they have none in common, to
    the latest: the ones before were lost.
    """
    rows: list[FrameRow] = []
    asked: dict[tuple[str, bool, str], list[FrameModel]] = {}
    answered: set[int] = set()
    before: FrameModel | None = None
    for frame in frames:
        row = FrameRow(frame, None, None if before is None else frame.ns - before.ns, [frame])
        open_ones = (asked.get((frame.line, not frame.sent, name), []) for name in frame.answers)
        request = next((_taken(requests, frame) for requests in open_ones if _still_open(requests, frame.ns)), None)
        if request is not None:
            answered.add(request.number)
            row.request, row.frames = request, [request, frame]
        if frame.asks:
            asked.setdefault(frame.message, []).append(frame)
        rows.append(row)
        before = frame
    return [row for row in rows if row.number not in answered]


def _still_open(requests: list[FrameModel], now_ns: int) -> bool:
    """Take out of the open requests those that are too old to be answered; say whether any is left."""
    requests[:] = [request for request in requests if now_ns - request.ns <= _ANSWERED_WITHIN_NS]
    return bool(requests)


def _taken(requests: list[FrameModel], answer: FrameModel) -> FrameModel:
    """Take out of the open requests the one that is answered, and those that will not be."""
    said = answer.item.fields.items()
    found = ((sum(one in said for one in request.item.fields.items()), at) for at, request in enumerate(requests))
    alike, at = max(found)
    request = requests.pop(at)
    if not alike:
        requests.clear()
    return request


def _name(frame: FrameModel | None) -> str:
    return "" if frame is None else frame.item.name
