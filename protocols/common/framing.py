"""Finds frames in a stream. At each byte it asks whether a frame begins there; each frame must show where it ends.

A byte that begins no frame is dropped, with the reason. Dropped bytes in a row with the same reason are one piece. If
the end of a rejected frame is known, as of a text line with a wrong checksum, the frame is dropped as a whole.
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
    TOO_LONG = "longer than any frame"


Look = Callable[[bytes], "Frame | Dropped | enum.Enum | None"]
"""Says what some bytes begin with: a frame; bytes that are none; why the first byte is none; None for more."""


class ScanningReader:
    """See the module.

    Args:
        look: looks at one byte or more and returns the frame that they begin with, the reason why they begin none, or
            None if it needs more bytes.
        gap_ns: the longest pause within a frame, in ns. After a longer pause a new frame begins. None for no limit.
        longest: the longest frame, in bytes. `look` gets no more bytes than this.
    """

    def __init__(self, look: Look, gap_ns: int | None = None, longest: int = 1024) -> None:
        self._look = look
        self._gap_ns = gap_ns
        self._longest = longest
        self._held = b""
        self._latest_ns = 0

    def receive(self, data: bytes, now_ns: int) -> list[Frame | Dropped]:
        """Take bytes that came at a time, in ns; return what they complete, in order.

        Raises:
            ValueError: `look` has found something without bytes.
        """
        late = self._gap_ns is not None and now_ns - self._latest_ns > self._gap_ns
        found: list[Frame | Dropped] = [*self.reset()] if late else []
        self._latest_ns = now_ns
        held, at, dropped = self._held + data, 0, _Run()
        while at < len(held) and (one := self._first(held[at : at + self._longest])) is not None:
            if isinstance(one, enum.Enum):
                found += dropped.add(one, held[at])
                at += 1
            else:
                found += [*dropped.end(), one]
                at += len(_bytes_of(one))
        self._held = held[at:]
        return [*found, *dropped.end()]

    def reset(self) -> list[Dropped]:
        """Give up an unfinished frame, and return it."""
        held, self._held = self._held, b""
        return [Dropped(Unfinished.ABANDONED, held)] if held else []

    def _first(self, shown: bytes) -> Frame | Dropped | enum.Enum | None:
        one = self._look(shown)
        if one is None and len(shown) == self._longest:
            return Unfinished.TOO_LONG
        if isinstance(one, Frame | Dropped) and not _bytes_of(one):
            raise ValueError("a frame without bytes was found, or one without bytes was dropped")
        return one


def _bytes_of(found: Frame | Dropped) -> bytes:
    return found.raw if isinstance(found, Frame) else found.data


class _Run:
    """Bytes in a row that were dropped for one reason."""

    def __init__(self) -> None:
        self._reason: enum.Enum | None = None
        self._bytes = bytearray()

    def add(self, reason: enum.Enum, byte: int) -> list[Dropped]:
        """Take one more; return those before it if their reason is another one."""
        ended = [] if reason is self._reason else self.end()
        self._reason = reason
        self._bytes.append(byte)
        return ended

    def end(self) -> list[Dropped]:
        """Return what there is."""
        if self._reason is None:
            return []
        ended = [Dropped(self._reason, bytes(self._bytes))]
        self._reason = None
        self._bytes.clear()
        return ended
