"""Follows a journal while it is written: the events since the last look, also across its rotation."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec

__all__ = ["Follower"]

Event = Mapping[str, Any]
_READ_BYTES = 1 << 18


class Follower:
    """Reads a journal from its beginning; the file may not be there yet.

    Args:
        path: the journal.

    Attributes:
        header: its first line; empty before it was read.
    """

    def __init__(self, path: Path) -> None:
        self.header: Event = {}
        self._path = path
        self._file: int | None = None
        self._data = b""
        self._decode = msgspec.json.Decoder(type=dict[str, Any]).decode

    def close(self) -> None:
        """Let go of the file."""
        if self._file is not None:
            os.close(self._file)
            self._file = None

    def news(self) -> list[Event]:
        """Return the events since the last call, at most some thousands of them at once."""
        if self._file is None and not self._open():
            return []
        assert self._file is not None
        data = os.read(self._file, _READ_BYTES)
        if not data and self._was_rotated():
            data = os.read(self._file, _READ_BYTES)  # what was written between the last look and the rotation
            if not data:
                self.close()
                self._open()
                data = os.read(self._file, _READ_BYTES)
        *lines, self._data = (self._data + data).split(b"\n")
        return [event for line in lines if (event := self._read(line)) is not None]

    @property
    def waiting(self) -> int:
        """How many bytes of the file are not read yet."""
        if self._file is None:
            return 0
        return max(0, os.fstat(self._file).st_size - os.lseek(self._file, 0, os.SEEK_CUR))

    def pass_over(self, keep: int) -> int:
        """Go on with the last `keep` bytes of the file; return how many bytes nobody will have seen."""
        passed = self.waiting - keep
        if self._file is None or passed <= 0:
            return 0
        os.lseek(self._file, passed, os.SEEK_CUR)
        self._data = b""  # what is left of the line in which it goes on is no event
        return passed

    def _open(self) -> bool:
        try:
            self._file = os.open(self._path, os.O_RDONLY)
        except OSError:
            return False
        self._data = b""
        return True

    def _was_rotated(self) -> bool:
        assert self._file is not None
        try:
            return self._path.stat().st_ino != os.fstat(self._file).st_ino
        except OSError:
            return False

    def _read(self, line: bytes) -> Event | None:
        try:
            event = self._decode(line)
        except (msgspec.DecodeError, UnicodeDecodeError):
            return None
        if event.get("kind") == "journal":
            self.header = event
            return None
        return event if isinstance(event.get("ns"), int) and "kind" in event else None
