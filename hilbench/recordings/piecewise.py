"""A journal that is read piece by piece: in memory is where its events stand, not what they say."""

from __future__ import annotations

import os
from array import array
from collections.abc import Sequence
from pathlib import Path

import msgspec

from hilbench.errors import UnavailableError
from hilbench.recordings.event_form import wrong_with
from hilbench.recordings.layout import Event
from hilbench.recordings.reading import FORMATS, read_recording

__all__ = ["JournalPieces", "Pieces", "open_pieces"]

_READ_BYTES = 1 << 16
_READ_EVENTS = 400
"""What is read at once: some milliseconds of work for whoever takes it (choices)."""
_decode = msgspec.json.Decoder(dict[str, object]).decode


class Pieces:
    """A recording whose events are all in memory.

    Args:
        header: of the recording.
        events: all of them, in order.
        problem: what ended the reading before the end of the file; None if nothing did.

    Attributes:
        header: as given.
        problem: as given.
        share: how much of the recording has been read, 0 to 1.
    """

    def __init__(self, header: Event, events: Sequence[Event], problem: str | None = None) -> None:
        self.header = header
        self.problem = problem
        self.share = 0.0
        self._events = [event for event in events if isinstance(event.get("ns"), int)]
        self._read = 0

    def read(self) -> Sequence[Event]:
        """Return the next events, in order; none after the last."""
        taken = self._events[self._read : self._read + _READ_EVENTS]
        self._read += len(taken)
        self.share = self._read / max(1, len(self._events))
        return taken

    def between(self, begin: int, end: int) -> Sequence[Event]:
        """Return the events from number `begin` to before number `end`, of those that were read."""
        return self._events[begin:end]


class JournalPieces(Pieces):
    """The journal in a file, as long as it is when this is made.

    Args:
        file: a descriptor of it; it is closed with the object.
        header: its first line.
        begin: where the second line begins, in bytes.
    """

    def __init__(self, file: int, header: Event, begin: int) -> None:
        super().__init__(header, ())
        self._file = file
        self._length = os.fstat(file).st_size
        self._at = begin
        self._lines = 1
        self._starts = array("Q")

    def __del__(self) -> None:
        """Let go of the file."""
        os.close(self._file)

    def read(self) -> Sequence[Event]:
        """Return the events of the next tens of thousands of bytes; `problem` says why there are no more."""
        taken: list[Event] = []
        if self._at == self._length or self.problem is not None:
            return taken
        for line in self._next_lines():
            self._lines += 1
            event = self._checked(line)
            if event is None:
                break
            self._starts.append(self._at)
            taken.append(event)
            self._at += len(line) + 1
        self.share = self._at / self._length
        return taken

    def between(self, begin: int, end: int) -> Sequence[Event]:
        """Return the events from number `begin` to before number `end`, of those that were read."""
        if begin >= end:
            return ()
        last = self._starts[end] if end < len(self._starts) else self._at
        data = os.pread(self._file, last - self._starts[begin], self._starts[begin])
        return [event for line in data.split(b"\n") if (event := _event_in(line)) is not None]

    def _next_lines(self) -> list[bytes]:
        """Return the whole lines that come next, without their ends."""
        size = _READ_BYTES
        while True:
            data = os.pread(self._file, min(size, self._length - self._at), self._at)
            *lines, _ = data.split(b"\n")
            if lines:
                return lines
            if len(data) < size:
                self.problem = f"cut in line {self._lines + 1}"
                return []
            size *= 2

    def _checked(self, line: bytes) -> Event | None:
        """Return the event of a line; None if it is damaged, which is a problem."""
        event = _event_in(line)
        if event is None:
            self.problem = f"line {self._lines} cannot be read"
        elif wrong := wrong_with(event):
            self.problem = f"event {self._lines - 1} is damaged: {wrong}"
        return event if self.problem is None else None


def open_pieces(path: Path) -> Pieces:
    """Open a recording: a journal piece by piece, any other format at once.

    Raises:
        UnavailableError: it cannot be read, or is no recording.
    """
    try:
        file = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    except OSError as error:
        raise UnavailableError(f"cannot be read: {error.strerror or error}", where=str(path)) from error
    first = _first_line(file)
    header = _event_in(first)
    if header is not None and first.startswith(FORMATS["journal"][0]):
        return JournalPieces(file, header, len(first) + 1)
    os.close(file)
    recording = read_recording(path)
    return Pieces(recording.header, recording.events, recording.problem)


def _first_line(file: int) -> bytes:
    """Return the first line of a journal without its end; nothing of what is no file, no journal, or has no end."""
    data = b""
    try:
        while not data or (b"\n" not in data and data.startswith(FORMATS["journal"][0])):
            more = os.pread(file, _READ_BYTES, len(data))
            if not more:
                return b""
            data += more
    except OSError:
        return b""
    return data.partition(b"\n")[0] if b"\n" in data else b""


def _event_in(line: bytes) -> Event | None:
    try:
        event = _decode(line)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return None
    return event if "kind" in event else None
