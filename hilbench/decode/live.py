"""Frames as they pass, printed by a thread of its own: who hands bytes on must never wait for who reads."""

from __future__ import annotations

import contextlib
import threading
from queue import Empty, Full, Queue

from hilbench.decode.run import Totals, decode
from hilbench.errors import HilbenchError, PluginError
from hilbench.plugins.blame import place_of
from hilbench.plugins.discovery import PLUGINS
from hilbench.plugins.protocol import ProtocolPlugin
from hilbench.recordings.chunks import Chunk
from hilbench.terminal.console import Console

__all__ = ["LiveDecoder"]

_CHUNKS = 10_000
"""What may wait to be printed (choice); what is more is not shown, and counted."""
_PATIENCE_S = 1.0
"""How long a reader who takes nothing is waited for at the end (choice)."""
_SPEAKERS = {"client": "host", "server": "target"}


class LiveDecoder:
    """Decodes and prints what it receives.

    Args:
        protocol: what is spoken.
        options: how its frames are read, its own record.
        console: where lines go.
        as_json: as JSON instead of for people.
        patience_s: how long a reader who takes nothing is waited for at the end, in seconds of the host.

    Attributes:
        totals: what the bytes came to.
        skipped: bytes that were not shown because nobody read fast enough.
        unread: whether the last lines were not printed because their reader took nothing.
    """

    def __init__(
        self,
        protocol: ProtocolPlugin,
        options: object,
        console: Console,
        *,
        as_json: bool,
        patience_s: float = _PATIENCE_S,
    ) -> None:
        self.totals = Totals()
        self.skipped = 0
        self.unread = False
        self._console = console
        self._patience_s = patience_s
        self._ending = False
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
        """Print what is left, as long as somebody reads it.

        Raises:
            UnavailableError: the lines could not be written.
        """
        self._ending = True
        self._end_queue()
        self._thread.join()
        while not self._queue.empty():
            self._make_room()
        if self._failure is not None:
            raise self._failure

    def _end_queue(self) -> None:
        while self._thread.is_alive():
            with contextlib.suppress(Full):
                self._queue.put(None, timeout=0.1)
                return
            self._make_room()

    def _make_room(self) -> None:
        try:
            chunk = self._queue.get_nowait()
        except Empty:
            return
        self.skipped += len(chunk.data) if chunk is not None else 0

    def _print(self) -> None:
        try:
            for lines in self._lines:
                self.unread = not self._console.data_as_read(lines, self._tired)
                if self.unread or self._console.reader_gone:
                    return
        except HilbenchError as error:
            self._failure = error
        except Exception as error:
            place = place_of(error, PLUGINS.brought)
            if not place:
                raise
            self._failure = PluginError(f"{type(error).__name__}: {error}", where=place)

    def _tired(self, waited_s: float) -> bool:
        return self._ending and waited_s >= self._patience_s
