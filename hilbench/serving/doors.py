"""Several doors to one port: whose the line is when clients come to more than one of them.

A robot has one host connector. When a pty and a socket are offered at the same time, the line has the bytes of all who
are there, and each gets what comes out; or it is of one alone, and what another sends meanwhile is lost and counted.
That is then the first client, until he leaves, or the newest: a socket of another is closed, a pseudo-terminal cannot
be, and has the line again once the newest has gone.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from hilbench.errors import PortClosedError, UnavailableError
from hilbench.links import Port
from hilbench.links.door import Door
from hilbench.links.front import PortInFront
from hilbench.links.port import PortBase, Refused, raise_it
from hilbench.links.turns import Turns
from hilbench.terminal.options import Clients

_RELIEVED_NS = 200_000_000
"""So long after a client has come, another one that leaves had gone before (choice): that it has is seen when its last
bytes are through, and at another door than the coming of the next."""


class LastingLine(PortInFront):
    """A port whose owner is not told that the far end has hung up: a serial line carries no such thing."""

    def _line_changed(self, up: bool, at_ns: int) -> None:
        if up:
            super()._line_changed(up, at_ns)


class SharedDoor(PortBase):
    """One port made of several doors.

    Args:
        doors: at least one; all at the same rate.
        clients: who is served.
    """

    def __init__(self, doors: Sequence[Port], clients: Clients = Clients.FIRST) -> None:
        super().__init__("+".join(door.name for door in doors))
        self._doors = tuple(doors)
        self._clients = clients
        self._there: list[Port] = []  # the doors at which somebody is, by when they came
        self._came_ns: dict[str, int] = {}
        turns = Turns()
        for door in self._doors:
            door.on_receive = partial(self._received, door)
            door.on_line = partial(self._line_changed, door)
            door.on_break = partial(self._break, door)
            door.on_sent = partial(self._sent, door)
            if isinstance(door, Door) and clients is Clients.ALL:
                door.turns = turns

    @property
    def baud(self) -> int:
        """Bits per second of every door, 0 for no pace."""
        return self._doors[0].baud

    @baud.setter
    def baud(self, baud: int) -> None:
        for door in self._doors:
            door.baud = baud

    def write(self, data: bytes) -> None:
        """Hand bytes to whoever has the line; without anybody they are lost and counted."""
        if self.closed:
            raise PortClosedError("written to after it was closed", where=self.name)
        served = self._served
        for door in served:
            door.write(data)
        if not served:
            self.counters.sent += len(data)
            self.counters.lost += len(data)

    @property
    def pending(self) -> int:
        """Bytes on their way to whoever has the line."""
        return max((door.pending for door in self._served), default=0)

    def withdraw(self, keep: int) -> None:
        """Take back what is not out yet to whoever has the line, but for the next `keep` bytes."""
        for door in self._served:
            door.withdraw(keep)

    def send_break(self, duration_ns: int, refused: Refused = raise_it) -> None:
        """Send a break to whoever has the line.

        Raises:
            UnavailableError: none of these doors knows breaks.
        """
        served = self._served
        errors = []
        for door in served:
            try:
                door.send_break(duration_ns, refused)
            except UnavailableError as error:
                errors.append(error)
        if errors and len(errors) == len(served):
            self.counters.breaks_unsent += 1
            raise errors[0]

    def close(self) -> None:
        """Close all doors; a second call does nothing."""
        self.closed = True
        self.line_is_up = False
        self._there.clear()
        for door in self._doors:
            door.close()

    @property
    def _served(self) -> list[Port]:
        """The doors that have the line."""
        match self._clients:
            case Clients.ALL:
                return self._there[:]
            case Clients.NEWEST:
                return self._there[-1:]
            case Clients.FIRST:
                return self._there[:1]

    def _sent(self, door: Port, data: bytes, at_ns: int) -> None:
        if door in self._served[:1]:
            self.counters.sent += len(data)
            self.on_sent(data, at_ns)

    def _break(self, door: Port, at_ns: int) -> None:
        if door in self._served:
            self.counters.breaks += 1
            self.break_ns = door.break_ns
            self.on_break(at_ns)

    def _received(self, door: Port, data: bytes, at_ns: int) -> None:
        if door in self._served:
            self._deliver(data, at_ns)
        else:
            self.counters.refused += len(data)

    def _line_changed(self, door: Port, up: bool, at_ns: int) -> None:
        if up == (door in self._there):
            return
        before = self._served
        if up:
            self._there.append(door)
            self._came_ns[door.name] = at_ns
        else:
            self._there.remove(door)
        now = self._served
        if isinstance(door, Door) and before:
            self._tell(door, up=up, was_served=door in before)
        if before and (not now or (now != before and self._clients is not Clients.ALL) or self._is_relieved(up, at_ns)):
            self._set_line(False, at_ns)
        if now:
            self._set_line(True, at_ns)
        if self._clients is Clients.NEWEST and up:
            for other in self._there[:-1]:
                if isinstance(other, Door):
                    other.disconnect()

    def _is_relieved(self, up: bool, at_ns: int) -> bool:
        """Say whether all who are there have only just come, and the one before them leaves: it was gone by then."""
        if up or self._clients is not Clients.ALL:
            return False
        return all(at_ns - self._came_ns[door.name] < _RELIEVED_NS for door in self._there)

    def _tell(self, door: Door, *, up: bool, was_served: bool) -> None:
        """Have the door tell of a client that comes or leaves while the line has another one."""
        if not up:
            if not was_served:
                first = self._clients is Clients.FIRST
                door.on_visit("the ignored client left" if first else "the previous client is gone")
            elif self._clients is Clients.ALL and self._there:
                door.on_visit("one client left; others are still connected, at other endpoints")
        elif self._clients is Clients.ALL:
            door.on_visit("another client came; the others stay connected, at other endpoints")
        elif self._clients is Clients.NEWEST:
            door.on_visit("another client came and took over the line")
        else:
            door.on_visit("another client came and is ignored: the first one has the line, at another endpoint")
