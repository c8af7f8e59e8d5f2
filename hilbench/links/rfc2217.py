"""A door for programs that open a serial port of another machine: Telnet with the Com Port Control Option (RFC 2217).

As the TCP door, but the client sets its rate, as at a pty: on a real line both ends must have the same. What the client
may ask for, and what it is answered, is in `hilbench.links.com_port`. Several clients have one port: its rate, DTR and
RTS are those that one of them set last, as at a pty that several programs have open.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from functools import partial

from hilbench.clock import NS_PER_MS, EventClass, Scheduler
from hilbench.links.com_port import (
    JOINED,
    BreakSet,
    Bytes,
    ComPortEvent,
    ComPortServer,
    HeldBack,
    LinesSet,
    Purged,
    RateSet,
)
from hilbench.links.port import USUAL_BREAK_NS, Line, ModemLines
from hilbench.links.tcp import Client, TcpDoor
from hilbench.links.telnet import escape
from hilbench.links.uart import Timeline
from hilbench.terminal.options import Clients

__all__ = ["Rfc2217Door"]

_HELD_BACK_BYTES = 16 * 1024
"""What is kept for a client that wants nothing for a while (choice); what is more is lost and counted."""
_RETRY_NS = 2 * NS_PER_MS


@dataclass(slots=True, kw_only=True)
class _Session:
    """What is between the door and one client.

    Attributes:
        server: what it asks for, and is answered.
        owed: what stands before all else to it: it must not be torn.
        kept: what it gets later, while it wants nothing.
        flushing: whether what is owed is tried again in a while.
        broken_ns: when it began to hold the line low.
    """

    server: ComPortServer
    owed: bytearray = field(default_factory=bytearray)
    kept: bytearray | None = None
    flushing: bool = False
    broken_ns: int = 0


class Rfc2217Door(TcpDoor):
    """A listening TCP socket that speaks RFC 2217; the line is up while a client is connected.

    Args:
        scheduler: Owner of bench time, locked to the host's clock before it runs.
        address: `[HOST:]PORT`; port 0 takes a free one.
        line: Baud rate of the wire behind the door, 0 for no pace.
        any_baud: Understand a client whatever rate it has set.
        clients: Who is served; a client that is turned away is counted.
        name: For the journal and for messages.
        chip_time: Time of the chip whose USART the door leads to; None if it leads to anything else.

    Raises:
        UsageError: the address is not one.
        UnavailableError: the port is in use, or the host is not this one.
    """

    KNOWS_BREAKS = True

    def __init__(
        self,
        scheduler: Scheduler,
        address: str,
        line: Line | None = None,
        *,
        any_baud: bool = False,
        clients: Clients = Clients.FIRST,
        name: str = "rfc2217",
        chip_time: Timeline | None = None,
    ) -> None:
        super().__init__(scheduler, address, line, clients=clients, name=name, chip_time=chip_time)
        self.any_baud = any_baud
        self._lines = JOINED
        self._sessions: dict[Client, _Session] = {}
        self._client_rate: int | None = None
        self._breaks: deque[int] = deque()  # how long each was that waits for its turn, in ns

    @property
    def client_baud(self) -> int:
        """The rate that the client has set, bit/s; that of the line before it sets any."""
        return self.baud if self._client_rate is None else self._client_rate

    def follow(self, was_baud: int, *, unasked: bool) -> None:
        """See `Door.follow`."""
        if self._client_rate is None or (unasked and self._client_rate == was_baud):
            self._client_rate = None
            for session in self._sessions.values():
                session.server.baud = self.baud

    def tell_lines(self, lines: ModemLines) -> bool:
        """See `Door.tell_lines`; a client that comes later is notified, too."""
        self._lines = lines
        for client, session in self._sessions.items():
            session.server.tell_lines(lines)
            self._answer(client, session)
        return True

    def _greet(self, client: Client) -> None:
        self._garbled = False
        if not self._sessions:
            self._client_rate = None
        server = ComPortServer(self.client_baud, self._lines)
        for session in self._sessions.values():
            server.dtr, server.rts = session.server.dtr, session.server.rts  # they are the same for all of them
        self._sessions[client] = _Session(server=server)
        self._answer(client, self._sessions[client])

    def _drop(self, client: Client) -> None:
        super()._drop(client)
        del self._sessions[client]

    def _take(self, client: Client, data: bytes, at_ns: int) -> None:
        session = self._sessions[client]
        for event in session.server.receive(data):
            self._obey(client, session, event, at_ns)
        self._answer(client, session)

    def _obey(self, client: Client, session: _Session, event: ComPortEvent, at_ns: int) -> None:
        match event:
            case Bytes(data=data):
                self._hear(client.input, data, at_ns)
            case RateSet(baud=baud):
                self._client_rate = baud
                for other in self._sessions.values():
                    other.server.baud = baud
            case BreakSet(on=True):
                session.broken_ns = at_ns
            case BreakSet():
                self._in_order(at_ns, partial(self._client_broke, at_ns - session.broken_ns))
            case LinesSet(dtr=dtr, rts=rts):
                for other in self._sessions.values():
                    other.server.dtr, other.server.rts = session.server.dtr, session.server.rts
                self._in_order(at_ns, lambda: self.on_lines(dtr, rts, at_ns))
            case Purged():
                self._in_order(at_ns, self._purge)
            case HeldBack(on=on):
                self._hold_back(client, session, on)

    def _client_broke(self, duration_ns: int) -> None:
        """Have the line learn of a break that is over, behind the bytes that were sent before it.

        A chip hears it from its beginning on, so what was sent behind it waits.
        """
        self._breaks.append(duration_ns)
        held_ns = max(duration_ns or USUAL_BREAK_NS, 2 * self._incoming.byte_ns)
        self.turns.take(self, 0, lambda: self._incoming.send_break(0 if self._out_has_pace else held_ns))

    def _break_in(self, at_ns: int) -> None:
        if self.closed or not self._breaks:
            return
        self.break_ns = self._breaks.popleft()
        self.counters.breaks += 1
        self.on_break(at_ns)

    def _purge(self) -> None:
        self.counters.withdrawn += self.turns.forget(self) + self._incoming.withdraw(0)
        self._breaks.clear()

    def _forget_incoming(self) -> None:
        super()._forget_incoming()
        self._breaks.clear()

    def _break_out(self, _at_ns: int) -> None:
        for client, session in self._sessions.items():
            session.server.tell_break()
            self._answer(client, session)

    # --- to the client

    def _put(self, data: bytes, _at_ns: int) -> None:
        self._share_out(self._across(data, self.baud, self.client_baud))

    def _give(self, client: Client, data: bytes) -> int:
        session = self._sessions[client]
        if session.kept is not None:
            kept = data[: _HELD_BACK_BYTES - len(session.kept)]
            session.kept += kept
            return len(kept)
        room = client.room - len(session.owed)
        taken = data[: max(0, room)]
        while len(escape(taken)) > room >= 0 and taken:
            taken = taken[: len(taken) - max(1, (len(escape(taken)) - room) // 2)]
        session.owed += escape(taken)
        self._flush(client, session)
        return len(taken)

    def _hold_back(self, client: Client, session: _Session, on: bool) -> None:
        if on and session.kept is None:
            session.kept = bytearray()
        elif not on and session.kept is not None:
            session.owed += escape(bytes(session.kept))
            session.kept = None
            self._flush(client, session)

    def _answer(self, client: Client, session: _Session) -> None:
        session.owed += session.server.answers
        session.server.answers.clear()
        self._flush(client, session)

    def _flush(self, client: Client, session: _Session) -> None:
        del session.owed[: client.send(bytes(session.owed))]
        if session.owed and not session.flushing:
            session.flushing = True
            self._scheduler.after(
                _RETRY_NS, partial(self._flush_on, client, session), order=EventClass.BYTE, source=self.name
            )

    def _flush_on(self, client: Client, session: _Session) -> None:
        session.flushing = False
        if client in self._sessions:
            self._flush(client, session)
