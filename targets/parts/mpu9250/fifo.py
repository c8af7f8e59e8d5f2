"""The FIFO (PS-MPU-9250A-01 section 4.17, RM-MPU-9250A-00 sections 4.5, 4.36 and 4.37)."""

from __future__ import annotations

from collections import deque

__all__ = ["Fifo"]


class Fifo:
    """See the module.

    Args:
        size: how many bytes it holds.

    Attributes:
        keeps_old: FIFO_MODE 1: what does not fit is lost; else the oldest bytes are.
    """

    def __init__(self, size: int) -> None:
        self._size = size
        self.keeps_old = False
        self._bytes: deque[int] = deque()
        self._last = 0

    @property
    def count(self) -> int:
        """Bytes in it."""
        return len(self._bytes)

    def clear(self) -> None:
        """Throw everything away."""
        self._bytes.clear()

    def put(self, data: bytes) -> bool:
        """Add bytes; return whether some did not fit."""
        room = self._size - len(self._bytes)
        self._bytes.extend(data[:room] if self.keeps_old else data)
        while len(self._bytes) > self._size:
            self._bytes.popleft()
        return len(data) > room

    def take(self) -> int:
        """Return the oldest byte and drop it; of an empty FIFO the byte that was read last."""
        if self._bytes:
            self._last = self._bytes.popleft()
        return self._last
