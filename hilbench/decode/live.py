"""Frames as they pass, printed by a thread of its own: who hands bytes on must never wait for who reads."""

from __future__ import annotations

import threading
from queue import Empty, Full, Queue

from hilbench.console import Console
from hilbench.decode.chunks import Chunk
from hilbench.decode.reading import DecodeOptions
from hilbench.decode.run import Totals, decode
from hilbench.errors import HilbenchError

__all__ = ["LiveDecoder"]

_CHUNKS = 10_000
"""What may wait to be printed (choice); what is more is not shown, and counted."""
_SPEAKERS = {"client": "host", "server": "target"}


class LiveDecoder:
    """Decodes and prints what it is told of.

    Args:
        protocol: name in `hilbench.decode.decoders.DECODERS`.
        options: how bytes are read.
        console: where lines go.
        as_json: as JSON instead of for people.

    Attributes:
        totals: what the bytes came to.
        skipped: bytes that were not shown because nobody read fast enough.
    """

    def __init__(self, protocol: str, options: DecodeOptions, console: Console, *, as_json: bool) -> None:
        self.totals = Totals()
        self.skipped = 0
        self._console = console
        self._queue: Queue[Chunk | None] = Queue(_CHUNKS)
        self._failure: HilbenchError | None = None
        self._lines = decode(
            iter(self._queue.get, None),
            protocol,
            options,
            streams=frozenset(),
            speaker="",
            as_json=as_json,
            totals=self.totals,
        )
        self._thread = threading.Thread(target=self._print, name="decode", daemon=True)
        self._thread.start()

    def take(self, who: str, data: bytes, at_ns: int) -> None:
        """Take bytes that ``client`` or ``server`` has said at bench time `at_ns`; never waits."""
        try:
            self._queue.put_nowait(Chunk(data=data, stream=who, speaker=_SPEAKERS[who], ns=at_ns))
        except Full:
            self.skipped += len(data)

    def close(self) -> None:
        """Print what is left.

        Raises:
            UnavailableError: the lines could not be written.
        """
        while self._thread.is_alive():
            try:
                self._queue.put(None, timeout=0.1)
                break
            except Full:
                self._make_room()
        self._thread.join()
        if self._failure is not None:
            raise self._failure

    def _make_room(self) -> None:
        try:
            chunk = self._queue.get_nowait()
        except Empty:
            return
        self.skipped += len(chunk.data) if chunk is not None else 0

    def _print(self) -> None:
        try:
            for lines in self._lines:
                self._console.data(lines)
                if self._console.reader_gone:
                    return
        except HilbenchError as error:
            self._failure = error
