"""A receiver that takes lines for frames, as the author's client does, with the losses that come of it.

pyserial's readline ends at a newline or after its timeout of 1 s; what it returns is taken for a frame if it begins
with the sync word and is at least as long as its length byte says; the CRC is never looked at, and a payload of one
byte is not handed on (nhorro/ceai2020 intro_se/workspace/rover_groundcontrol/rover/serialprotocol.py,
`get_packet_payload` and `run`). So a newline in length, payload or CRC costs the frame: of N random payload bytes a
share of 1 - (255/256)^(N+2).
"""

from __future__ import annotations

from protocols.pkt.errors import LocalProtocolError
from protocols.pkt.framing import SYNC, TERMINATOR, Dropped, DropReason, Frame

__all__ = ["LINE_LIMIT", "LineReader"]

LINE_LIMIT = 1024
"""Bytes after which a line is cut though no newline came; pyserial has no limit (choice)."""

_HEADER = len(SYNC) + 1
_TRAILER = 3
_NEWLINE = TERMINATOR[0]


class LineReader:
    """Takes each line for a frame. It promises what `FrameReader` does.

    Args:
        timeout_ns: how long a line may take from its first byte, in ns; readline counts from its call instead.
    """

    def __init__(self, *, timeout_ns: int = 1_000_000_000) -> None:
        if timeout_ns <= 0:
            raise LocalProtocolError(f"timeout_ns is {timeout_ns}, not above 0")
        self._timeout_ns = timeout_ns
        self._line = bytearray()
        self._deadline_ns: int | None = None

    @property
    def held(self) -> int:
        """How many bytes wait for a newline; never more than `LINE_LIMIT`."""
        return len(self._line)

    def next_deadline_ns(self) -> int | None:
        """When the bytes held are taken for a line, in ns of bench time; None when none are held."""
        return self._deadline_ns

    def receive(self, data: bytes, now_ns: int) -> list[Frame | Dropped]:
        """Takes the bytes that came at `now_ns`, in ns of bench time, and returns what they complete."""
        found = self.expire(now_ns)
        at = 0
        while at < len(data):
            if not self._line:
                self._deadline_ns = now_ns + self._timeout_ns
            room = LINE_LIMIT - len(self._line)
            end = data.find(_NEWLINE, at, at + room)
            taken = data[at : end + 1 if end >= 0 else at + room]
            self._line += taken
            at += len(taken)
            if end >= 0 or len(self._line) == LINE_LIMIT:
                found.append(self._end())
        return found

    def expire(self, now_ns: int) -> list[Frame | Dropped]:
        """Takes the bytes held for a line if their time is over."""
        over = self._deadline_ns is not None and now_ns >= self._deadline_ns
        return [self._end()] if over else []

    def reset(self) -> list[Frame | Dropped]:
        """Takes the bytes held for a line at once: the line went down."""
        return [self._end()] if self._line else []

    def _end(self) -> Frame | Dropped:
        raw = bytes(self._line)
        self._line.clear()
        self._deadline_ns = None
        if not raw.startswith(SYNC):
            return Dropped(reason=DropReason.BAD_SYNC, data=raw)
        if len(raw) <= _HEADER or len(raw) < _HEADER + raw[_HEADER - 1] + _TRAILER or raw[_HEADER - 1] < 2:
            return Dropped(reason=DropReason.BAD_LENGTH, data=raw)
        return Frame(raw=raw, payload=raw[_HEADER : _HEADER + raw[_HEADER - 1]])
