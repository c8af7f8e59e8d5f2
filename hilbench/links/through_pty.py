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
from collections.abc import Callable

from hilbench.errors import UnavailableError
from hilbench.links.port import LinkCounters, Port

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


class ThroughPty:
    """A port of whose line a pseudo-terminal is a part; see `Port`."""

    def __init__(self, port: Port, passage: _Passage) -> None:
        self._port = port
        self._passage = passage
        self.on_receive: Callable[[bytes, int], None] = lambda _data, _at_ns: None
        port.on_receive = self._receive
        self.name = port.name
        self.comes_back = port.comes_back
        self.counters: LinkCounters = port.counters

    def _receive(self, data: bytes, at_ns: int) -> None:
        self.on_receive(self._passage.to_near_end(data), at_ns)

    def write(self, data: bytes) -> None:
        """See `Port`."""
        self._port.write(self._passage.to_far_end(data))

    @property
    def baud(self) -> int:
        """See `Port`."""
        return self._port.baud

    @baud.setter
    def baud(self, baud: int) -> None:
        self._port.baud = baud

    @property
    def line_is_up(self) -> bool:
        """See `Port`."""
        return self._port.line_is_up

    @line_is_up.setter
    def line_is_up(self, up: bool) -> None:
        self._port.line_is_up = up

    @property
    def closed(self) -> bool:
        """See `Port`."""
        return self._port.closed

    @closed.setter
    def closed(self, closed: bool) -> None:
        self._port.closed = closed

    @property
    def on_line(self) -> Callable[[bool, int], None]:
        """See `Port`."""
        return self._port.on_line

    @on_line.setter
    def on_line(self, callback: Callable[[bool, int], None]) -> None:
        self._port.on_line = callback

    @property
    def on_break(self) -> Callable[[int], None]:
        """See `Port`."""
        return self._port.on_break

    @on_break.setter
    def on_break(self, callback: Callable[[int], None]) -> None:
        self._port.on_break = callback

    @property
    def on_sent(self) -> Callable[[bytes, int], None]:
        """See `Port`."""
        return self._port.on_sent

    @on_sent.setter
    def on_sent(self, callback: Callable[[bytes, int], None]) -> None:
        self._port.on_sent = callback

    @property
    def pending(self) -> int:
        """See `Port`."""
        return self._port.pending

    def withdraw(self, keep: int) -> None:
        """See `Port`."""
        self._port.withdraw(keep)

    def send_break(self, duration_ns: int) -> None:
        """See `Port`; a pseudo-terminal knows no break, so it goes past."""
        self._port.send_break(duration_ns)

    def close(self) -> None:
        """See `Port`; the pseudo-terminal stays, for the next one of this name."""
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
