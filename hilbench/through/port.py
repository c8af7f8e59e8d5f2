"""A port whose bytes pass a door of this machine on their way."""

from __future__ import annotations

from typing import Protocol

from hilbench.links.port import Port, PortBase

__all__ = ["Passage", "ThroughPort"]


class Passage(Protocol):
    """Where bytes pass, in both directions; none is kept back."""

    def to_far_end(self, data: bytes) -> bytes:
        """Pass bytes from the near end; return what comes out.

        Raises:
            UnavailableError: some do not come out.
        """

    def to_near_end(self, data: bytes) -> bytes:
        """Pass bytes from the far end; return what comes out.

        Raises:
            UnavailableError: some do not come out.
        """


class ThroughPort(PortBase):
    """A port of whose line a passage is a part.

    Args:
        port: the port; its callbacks belong to this one from now on.
        passage: what the bytes pass; it stays when the port is closed, for the next one of this name.
    """

    def __init__(self, port: Port, passage: Passage) -> None:
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
        """Hand bytes to the port, by way of the passage."""
        self._port.write(self._passage.to_far_end(data))

    @property
    def pending(self) -> int:
        """Bytes written that are not out yet."""
        return self._port.pending

    def withdraw(self, keep: int) -> None:
        """Take back what is not out yet, but for the next `keep` bytes."""
        self._port.withdraw(keep)

    def send_break(self, duration_ns: int) -> None:
        """Hold the line low for `duration_ns`; a break goes past the passage: not every kind knows one."""
        self._port.send_break(duration_ns)

    def close(self) -> None:
        """Close the port."""
        self.closed = True
        self.line_is_up = False
        self._port.close()
