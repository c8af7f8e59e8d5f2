"""Bytes into the journal by the chunk: an event for each burst, but at least one for every 10 ms of it."""

from __future__ import annotations

from collections.abc import Callable

from hilbench.bench import Bench
from hilbench.clock import NS_PER_MS, Entry, EventClass

__all__ = ["ByteLog"]

CHUNK_NS = 10 * NS_PER_MS
"""From the first byte of a chunk to its event: eleven bytes at 9600 baud, 115 at 115200 (choice)."""


class ByteLog:
    """Collects the bytes of one direction of a line.

    Args:
        bench: whose journal it writes to.
        kind: ``tx`` for what the chip sends, ``rx`` for what it receives.
        source: the line, for the journal.
        due: called when a chunk has had its time, and has it flushed; `flush` if left out.
    """

    def __init__(self, bench: Bench, kind: str, source: str, due: Callable[[], None] | None = None) -> None:
        self._bench = bench
        self._kind = kind
        self._source = source
        self._data = bytearray()
        self._from_ns = 0
        self._when_due = due or self.flush
        self._due: Entry | None = None

    def add(self, data: bytes, at_ns: int) -> None:
        """Take bytes that were complete at `at_ns`, now or in the time of a chip that is ahead."""
        if not self._data:
            self._from_ns = at_ns
            when_ns = max(at_ns + CHUNK_NS, self._bench.now_ns)
            self._due = self._bench.scheduler.at(when_ns, self._when_due, order=EventClass.CHECK, source=self._source)
        self._data += data

    def flush(self) -> None:
        """Write what was collected; the next chunk has its whole time again."""
        if self._due is not None:
            self._bench.scheduler.cancel(self._due)
            self._due = None
        if self._data:
            data, self._data = bytes(self._data), bytearray()
            self._bench.record(self._kind, self._source, data=data, from_ns=self._from_ns)
