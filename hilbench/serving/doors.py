"""Several doors to one port: whoever comes first has the line until he leaves.

A robot has one host connector. When a pty and a socket are offered at the same time, the first client to come owns the
line; what another sends meanwhile is lost and counted, and the line is his once the first has gone.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from hilbench.errors import PortClosedError, UnavailableError
from hilbench.links import Port
from hilbench.links.port import PortBase, Refused, raise_it


class SharedDoor(PortBase):
    """One port made of several doors.

    Args:
        doors: at least one; all at the same rate.
    """

    def __init__(self, doors: Sequence[Port]) -> None:
        super().__init__("+".join(door.name for door in doors))
        self._doors = tuple(doors)
        self._owner: Port | None = None
        for door in self._doors:
            door.on_receive = partial(self._received, door)
            door.on_line = partial(self._line_changed, door)
            door.on_break = partial(self._break, door)
            door.on_sent = self._sent

    @property
    def baud(self) -> int:
        """Bits per second of every door, 0 for no pace."""
        return self._doors[0].baud

    @baud.setter
    def baud(self, baud: int) -> None:
        for door in self._doors:
            door.baud = baud

    def write(self, data: bytes) -> None:
        """Hand bytes to the client that has the line; without one they are lost and counted."""
        if self.closed:
            raise PortClosedError("written to after it was closed", where=self.name)
        if self._owner is not None:
            self._owner.write(data)
        else:
            self.counters.sent += len(data)
            self.counters.lost += len(data)

    @property
    def pending(self) -> int:
        """Bytes on their way to the client that has the line."""
        return self._owner.pending if self._owner is not None else 0

    def withdraw(self, keep: int) -> None:
        """Take back what is not out yet to the client that has the line, but for the next `keep` bytes."""
        if self._owner is not None:
            self._owner.withdraw(keep)

    def send_break(self, duration_ns: int, refused: Refused = raise_it) -> None:
        """Send a break to the client that has the line."""
        if self._owner is None:
            return
        try:
            self._owner.send_break(duration_ns, refused)
        except UnavailableError:
            self.counters.breaks_unsent += 1
            raise

    def close(self) -> None:
        """Close all doors; a second call does nothing."""
        self.closed = True
        self.line_is_up = False
        self._owner = None
        for door in self._doors:
            door.close()

    def _sent(self, data: bytes, at_ns: int) -> None:
        self.counters.sent += len(data)
        self.on_sent(data, at_ns)

    def _break(self, door: Port, at_ns: int) -> None:
        if door is self._owner:
            self.counters.breaks += 1
            self.break_ns = door.break_ns
            self.on_break(at_ns)

    def _received(self, door: Port, data: bytes, at_ns: int) -> None:
        if door is self._owner:
            self._deliver(data, at_ns)
        else:
            self.counters.refused += len(data)

    def _line_changed(self, door: Port, up: bool, at_ns: int) -> None:
        if up and self._owner is None:
            self._owner = door
            self._set_line(True, at_ns)
        elif not up and door is self._owner:
            self._set_line(False, at_ns)
            self._owner = next((other for other in self._doors if other.line_is_up), None)
            if self._owner is not None:
                self._set_line(True, at_ns)
