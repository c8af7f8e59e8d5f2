"""A line that passes a pseudo-terminal of this machine on its way, in virtual time.

What one end writes goes into the terminal on its side and comes out of it on the other before time moves on: so the
bytes have been where those of a program at a serial port have been, the line discipline included, and a run is as
repeatable as without. The end at hand has the slave, as a program has that opens a port; the far end has the master.
"""

from __future__ import annotations

import os
import select
import termios
import tty
import weakref

from hilbench.errors import UnavailableError
from hilbench.links.port import Port, PortBase

__all__ = ["PtyPassages", "ThroughPty"]

_PIECE_BYTES = 1024  # a terminal keeps 4095 bytes that nobody has read (n_tty of Linux)
_PATIENCE_MS = 10_000
"""A terminal passes bytes on at once; what has not come by then does not come (choice)."""


class _Passage:
    """One pseudo-terminal, raw."""

    def __init__(self, name: str) -> None:
        self._name = name
        try:
            self._master, self._slave = os.openpty()
        except OSError as error:
            raise UnavailableError(f"no pseudo-terminal: {error.strerror}", where=name) from error
        weakref.finalize(self, _close, self._master, self._slave)
        tty.setraw(self._slave, termios.TCSANOW)

    def to_far_end(self, data: bytes) -> bytes:
        """Pass bytes from the slave to the master; return what comes out."""
        return self._pass(self._slave, self._master, data)

    def to_near_end(self, data: bytes) -> bytes:
        """Pass bytes from the master to the slave; return what comes out."""
        return self._pass(self._master, self._slave, data)

    def _pass(self, entrance: int, exit_: int, data: bytes) -> bytes:
        came = b""
        for start in range(0, len(data), _PIECE_BYTES):
            piece = data[start : start + _PIECE_BYTES]
            os.write(entrance, piece)
            came += self._take(exit_, len(piece))
        return came

    def _take(self, exit_: int, count: int) -> bytes:
        came = b""
        poll = select.poll()
        poll.register(exit_, select.POLLIN)
        while len(came) < count:
            if not poll.poll(_PATIENCE_MS):
                raise UnavailableError(
                    f"the pseudo-terminal has passed on {len(came)} of {count} bytes", where=self._name
                )
            came += os.read(exit_, count - len(came))
        return came


def _close(*descriptors: int) -> None:
    for descriptor in descriptors:
        os.close(descriptor)


class ThroughPty(PortBase):
    """A port of whose line a pseudo-terminal is a part.

    Args:
        port: the port; its callbacks belong to this one from now on.
        passage: the pseudo-terminal; it stays when the port is closed, for the next one of this name.
    """

    def __init__(self, port: Port, passage: _Passage) -> None:
        super().__init__(port.name)
        self._port = port
        self._passage = passage
        self.counters = port.counters
        self.line_is_up = port.line_is_up
        self.comes_back = port.comes_back
        port.on_receive = self._received
        port.on_line = self._set_line
        port.on_break = self._broke
        port.on_sent = self._handed_over

    def _received(self, data: bytes, at_ns: int) -> None:
        self.on_receive(self._passage.to_near_end(data), at_ns)

    def _broke(self, at_ns: int) -> None:
        self.on_break(at_ns)

    def _handed_over(self, data: bytes, at_ns: int) -> None:
        self.on_sent(data, at_ns)

    @property
    def baud(self) -> int:
        """The port's own rate, bit/s."""
        return self._port.baud

    @baud.setter
    def baud(self, baud: int) -> None:
        self._port.baud = baud

    def write(self, data: bytes) -> None:
        """Hand bytes to the port, by way of the pseudo-terminal."""
        self._port.write(self._passage.to_far_end(data))

    @property
    def pending(self) -> int:
        """Bytes written that are not out yet."""
        return self._port.pending

    def withdraw(self, keep: int) -> None:
        """Take back what is not out yet, but for the next `keep` bytes."""
        self._port.withdraw(keep)

    def send_break(self, duration_ns: int) -> None:
        """Hold the line low for `duration_ns`; a pseudo-terminal knows no break, so it goes past."""
        self._port.send_break(duration_ns)

    def close(self) -> None:
        """Close the port."""
        self.closed = True
        self.line_is_up = False
        self._port.close()


class PtyPassages:
    """One pseudo-terminal for each line, kept for the whole run."""

    def __init__(self) -> None:
        self._passages: dict[str, _Passage] = {}

    def __call__(self, port: Port) -> Port:
        """Return what stands for the port now."""
        if port.name not in self._passages:
            self._passages[port.name] = _Passage(port.name)
        return ThroughPty(port, self._passages[port.name])
