"""Finds frames in a stream by looking at what begins at each byte; for frames that say themselves how they end.

Bytes that begin no frame are dropped one by one, with the reason; those in a row with one reason are one piece.
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["Dropped", "Frame", "Look", "ScanningReader", "Unfinished"]


@dataclass(frozen=True, slots=True)
class Frame:
    """A sound frame.

    Attributes:
        raw: all of it.
        payload: what it carries.
    """

    raw: bytes
    payload: bytes


@dataclass(frozen=True, slots=True)
class Dropped:
    """Bytes that are no frame, and why."""

    reason: enum.Enum
    data: bytes


class Unfinished(enum.Enum):
    """Why the beginning of a frame is none."""

    ABANDONED = "unfinished frame abandoned"


Look = Callable[[bytes], "Frame | enum.Enum | None"]
"""Says what some bytes begin with: a frame, no frame and why, or None where it takes more bytes to say."""


class ScanningReader:
    """See the module.

    Args:
        look: says what some bytes begin with. It decides from a bounded number of bytes.
        gap_ns: the longest pause in a frame, in ns; what comes after a longer one is the beginning of something. None
            for any.
    """

    def __init__(self, look: Look, gap_ns: int | None = None) -> None:
        self._look = look
        self._gap_ns = gap_ns
        self._held = b""
        self._latest_ns = 0

    def receive(self, data: bytes, now_ns: int) -> list[Frame | Dropped]:
        """Take bytes that came at a time, in ns; return what they complete, in order. Raises nothing."""
        late = self._gap_ns is not None and now_ns - self._latest_ns > self._gap_ns
        found: list[Frame | Dropped] = [*self.reset()] if late else []
        self._latest_ns = now_ns
        self._held += data
        while self._held and (one := self._look(self._held)) is not None:
            size = len(one.raw) if isinstance(one, Frame) else 1
            first, self._held = self._held[:size], self._held[size:]
            latest = found[-1] if found else None
            if isinstance(one, Frame):
                found.append(one)
            elif isinstance(latest, Dropped) and latest.reason is one:
                found[-1] = Dropped(one, latest.data + first)
            else:
                found.append(Dropped(one, first))
        return found

    def reset(self) -> list[Dropped]:
        """Give up an unfinished frame, and return it."""
        held, self._held = self._held, b""
        return [Dropped(Unfinished.ABANDONED, held)] if held else []
