"""A pyserial object that has no descriptor, such as a client of RFC 2217, for a bench that must never wait.

Two threads do the waiting. One reads and puts what comes into a queue; a pipe, which has a descriptor, is readable when
there is something in it. The other writes, one chunk at a time. The bench's own thread never calls into the object
but to open it, to set it and to close it.
"""

from __future__ import annotations

import contextlib
import os
import threading
from queue import Empty, SimpleQueue
from typing import Any

__all__ = ["ThreadedStream"]

CHUNK_BYTES = 4096


class ThreadedStream:
    """Reads and writes a port by threads.

    Args:
        port: the port, open, with a read timeout: so often it is looked whether the threads should end.
        drain_s: how long closing waits for what is being written, in seconds of the host.
    """

    def __init__(self, port: Any, *, drain_s: float) -> None:
        self._port = port
        self._drain_s = drain_s
        self._came: SimpleQueue[bytes | Exception] = SimpleQueue()
        self._to_write: SimpleQueue[bytes | None] = SimpleQueue()
        self._writing = 0
        self._wake_read, self._wake_write = os.pipe()
        self._woken = False
        self._telling = threading.Lock()
        self._ending = False
        self._threads = [
            threading.Thread(target=run, name=f"{what} {port.port}", daemon=True)
            for what, run in (("read", self._read_on), ("write", self._write_on))
        ]
        for thread in self._threads:
            thread.start()

    def fileno(self) -> int:
        """Return the descriptor that is readable when `take` has something."""
        return self._wake_read

    @property
    def writing(self) -> int:
        """Bytes that were offered and are not written."""
        return self._writing

    def take(self) -> bytes:
        """Return the next bytes that were read; raises OSError for what ended reading or writing."""
        with self._telling:
            data = self._came.get_nowait()
            if self._came.empty():
                os.read(self._wake_read, 1)
                self._woken = False
        if isinstance(data, Exception):
            raise data
        return data

    def offer(self, data: bytes) -> int:
        """Have the beginning of `data` written; return how many bytes those are, 0 while others are being written."""
        if self._writing:
            return 0
        chunk = data[:CHUNK_BYTES]
        self._writing = len(chunk)
        self._to_write.put(chunk)
        return len(chunk)

    def close(self) -> int:
        """Write what was offered, close the port, end the threads; return how many bytes could not be written."""
        self._ending = True
        self._to_write.put(None)
        self._threads[1].join(self._drain_s)
        cancel = getattr(self._port, "cancel_read", None)
        if cancel is not None:
            with contextlib.suppress(OSError, AttributeError):
                cancel()
        unwritten = self._writing
        with contextlib.suppress(OSError):
            self._port.close()
        for thread in self._threads:
            thread.join()
        with contextlib.suppress(Empty):
            while True:
                self._came.get_nowait()
        os.close(self._wake_read)
        os.close(self._wake_write)
        return unwritten

    # --- in threads of their own

    def _read_on(self) -> None:
        while not self._ending:
            try:
                data = self._port.read(max(1, min(CHUNK_BYTES, self._port.in_waiting)))
            except (OSError, TypeError, AttributeError) as error:  # the latter two: closed under its hands
                self._tell(OSError(str(error)))
                return
            if data:
                self._tell(bytes(data))

    def _write_on(self) -> None:
        while (chunk := self._to_write.get()) is not None:
            try:
                self._port.write(chunk)
            except (OSError, TypeError, AttributeError) as error:
                self._tell(OSError(str(error)))
                return
            self._writing = 0

    def _tell(self, item: bytes | Exception) -> None:
        with self._telling:
            self._came.put(item)
            if not self._woken:  # one byte is enough: a full pipe would hold this thread
                self._woken = True
                os.write(self._wake_write, b"!")
