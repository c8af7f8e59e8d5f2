"""Reads a line so that each frame knows when its first byte came."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import Generic, TypeVar

__all__ = ["TimedReader"]

ItemT = TypeVar("ItemT")

_KEPT_BYTE_TIMES = 1024
_KEPT_BEGUN = 32


class TimedReader(Generic[ItemT]):
    """Gives a reader of frames one byte at a time, and remembers when each came.

    Args:
        read: takes bytes and the bench time at which they came, in ns; returns what they complete.

    Attributes:
        bytes_received: how many bytes came in all, or since it was set back to 0.
        begun: the latest bytes, that have completed nothing yet; `_KEPT_BEGUN` of them at most.
    """

    def __init__(self, read: Callable[[bytes, int], Iterable[ItemT]]) -> None:
        self.bytes_received = 0
        self.begun = b""
        self._read = read
        self._byte_times_ns: deque[int] = deque(maxlen=_KEPT_BYTE_TIMES)

    @property
    def last_byte_ns(self) -> int:
        """Bench time at which the latest byte came, in ns; there must have been one."""
        return self._byte_times_ns[-1]

    def receive(self, data: bytes, at_ns: int) -> Iterator[ItemT]:
        """Take the bytes that came at a bench time, in ns; give what they complete, each item at its last byte."""
        for byte in (data,) if len(data) == 1 else (data[index : index + 1] for index in range(len(data))):
            self.bytes_received += 1
            self._byte_times_ns.append(at_ns)
            self.begun = (self.begun + byte)[-_KEPT_BEGUN:]
            for item in self._read(byte, at_ns):
                self.begun = b""
                yield item

    def start_ns(self, frame: bytes) -> int:
        """Return the bench time, in ns, at which the first byte came of a frame that ends with the latest byte.

        Of a frame longer than what is remembered it is the oldest time that is.
        """
        return self._byte_times_ns[-min(len(frame), len(self._byte_times_ns))]
