"""An AUX serial port: bytes out by TTY commands, bytes in fetched by GETAUX.

The baud rate of the AUX side is not modelled: bytes cross at once.
"""

from __future__ import annotations

BUFFER = 1024
"""Bytes kept from the device; the oldest go first (choice: the real circular buffer's size is not published)."""
MOST_FETCHED = 200
"""Largest GETAUX argument (Pioneer 2 / PeopleBot Operations Manual, GETAUX)."""


class AuxPort:
    """One port.

    Args:
        loop_back: Connect Tx to Rx.
    """

    def __init__(self, *, loop_back: bool) -> None:
        self._loop_back = loop_back
        self._received = bytearray()
        self._sent = bytearray()
        self._wanted = 0

    def send(self, data: bytes) -> None:
        """TTY command: bytes to the device."""
        self._sent += data
        del self._sent[:-BUFFER]
        if self._loop_back:
            self.feed(data)

    def feed(self, data: bytes) -> None:
        """Bytes from the device."""
        self._received += data
        del self._received[:-BUFFER]

    def take_sent(self) -> bytes:
        """Take what the device was sent since the last call."""
        sent = bytes(self._sent)
        self._sent.clear()
        return sent

    def want(self, count: int) -> bool:
        """GETAUX: ask for `count` bytes, 1 to 200; 0 empties the buffer. False outside that range."""
        if not 0 <= count <= MOST_FETCHED:
            return False
        self._wanted = count
        if not count:
            self._received.clear()
        return True

    def due(self) -> bytes:
        """Return the bytes asked for once all of them are there; empty until then."""
        return bytes(self._received[: self._wanted]) if len(self._received) >= self._wanted else b""

    def take_due(self) -> bytes:
        """Take the bytes that are due; the request is then done."""
        due = self.due()
        if due:
            del self._received[: len(due)]
            self._wanted = 0
        return due

    def cancel(self) -> None:
        """Forget the request (end of a session)."""
        self._wanted = 0
