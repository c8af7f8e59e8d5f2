"""A door for programs that open a serial port of another machine: Telnet with the Com Port Control Option (RFC 2217).

As the TCP door, but the client sets its rate, as at a pty: on a real line both ends must have the same. What the client
may ask for, and what it is answered, is in `hilbench.links.com_port`.
"""

from __future__ import annotations

from collections import deque
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
from hilbench.links.door import Input
from hilbench.links.port import USUAL_BREAK_NS, Line, ModemLines
from hilbench.links.tcp import TcpDoor
from hilbench.links.telnet import escape
from hilbench.links.uart import Timeline

__all__ = ["Rfc2217Door"]

_HELD_BACK_BYTES = 16 * 1024
"""What is kept for a client that wants nothing for a while (choice); what is more is lost and counted."""
_RETRY_NS = 2 * NS_PER_MS


class Rfc2217Door(TcpDoor):
    """A listening TCP socket that speaks RFC 2217; the line is up while a client is connected.

    Args:
        scheduler: Owner of bench time, locked to the host's clock before it runs.
        address: `[HOST:]PORT`; port 0 takes a free one.
        line: Baud rate of the wire behind the door, 0 for no pace.
        any_baud: Understand a client whatever rate it has set.
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
        name: str = "rfc2217",
        chip_time: Timeline | None = None,
    ) -> None:
        super().__init__(scheduler, address, line, name=name, chip_time=chip_time)
        self.any_baud = any_baud
        self._lines = JOINED
        self._session = ComPortServer(self.baud)
        self._client_rate: int | None = None
        self._owed = bytearray()  # what stands before all else: it must not be torn
        self._kept: bytearray | None = None
        self._flushing = False
        self._broken_ns = 0
        self._breaks: deque[int] = deque()  # how long each was that waits for its turn, in ns

    @property
    def client_baud(self) -> int:
        """The rate that the client has set, bit/s; that of the line before it sets any."""
        return self.baud if self._client_rate is None else self._client_rate

    def follow(self, was_baud: int, *, unasked: bool) -> None:
        """See `Door.follow`."""
        if self._client_rate is None or (unasked and self._client_rate == was_baud):
            self._client_rate = None
            self._session.baud = self.baud

    def tell_lines(self, lines: ModemLines) -> bool:
        """See `Door.tell_lines`; a client that comes later is notified, too."""
        self._lines = lines
        self._session.tell_lines(lines)
        self._answer()
        return True

    def _greet(self) -> None:
        self._session = ComPortServer(self.baud, self._lines)
        self._client_rate = self._kept = None
        self._garbled = False
        self._breaks.clear()
        self._owed.clear()
        self._answer()

    def _take(self, source: Input, data: bytes, at_ns: int) -> None:
        for event in self._session.receive(data):
            self._obey(source, event, at_ns)
        self._answer()

    def _obey(self, source: Input, event: ComPortEvent, at_ns: int) -> None:
        match event:
            case Bytes(data=data):
                self._hear(source, data, at_ns)
            case RateSet(baud=baud):
                self._client_rate = baud
            case BreakSet(on=True):
                self._broken_ns = at_ns
            case BreakSet():
                self._in_order(at_ns, partial(self._client_broke, at_ns - self._broken_ns))
            case LinesSet(dtr=dtr, rts=rts):
                self._in_order(at_ns, lambda: self.on_lines(dtr, rts, at_ns))
            case Purged():
                self._in_order(at_ns, self._purge)
            case HeldBack(on=on):
                self._hold_back(on)

    def _client_broke(self, duration_ns: int) -> None:
        """Have the line learn of a break that is over, behind the bytes that were sent before it.

        A chip hears it from its beginning on, so what was sent behind it waits.
        """
        self._breaks.append(duration_ns)
        held_ns = max(duration_ns or USUAL_BREAK_NS, 2 * self._incoming.byte_ns)
        self._incoming.send_break(0 if self._out_has_pace else held_ns)

    def _break_in(self, at_ns: int) -> None:
        if self.closed or not self._breaks:
            return
        self.break_ns = self._breaks.popleft()
        self.counters.breaks += 1
        self.on_break(at_ns)

    def _purge(self) -> None:
        self.counters.withdrawn += self._incoming.withdraw(0)
        self._breaks.clear()

    def _break_out(self, _at_ns: int) -> None:
        self._session.tell_break()
        self._answer()

    # --- to the client

    def _put(self, data: bytes, _at_ns: int) -> None:
        heard = self._across(data, self.baud, self.client_baud)
        if self._kept is not None:
            kept = heard[: _HELD_BACK_BYTES - len(self._kept)]
            self._kept += kept
            self.counters.lost += len(heard) - len(kept)
            return
        room = self._room() - len(self._owed)
        taken = heard[: max(0, room)]
        while len(escape(taken)) > room >= 0 and taken:
            taken = taken[: len(taken) - max(1, (len(escape(taken)) - room) // 2)]
        self.counters.lost += len(heard) - len(taken)
        self._owed += escape(taken)
        self._flush()

    def _hold_back(self, on: bool) -> None:
        if on and self._kept is None:
            self._kept = bytearray()
        elif not on and self._kept is not None:
            self._owed += escape(bytes(self._kept))
            self._kept = None
            self._flush()

    def _answer(self) -> None:
        self._owed += self._session.answers
        self._session.answers.clear()
        self._flush()

    def _flush(self) -> None:
        del self._owed[: self._send(bytes(self._owed))]
        if self._owed and self._client is not None and not self._flushing:
            self._flushing = True
            self._scheduler.after(_RETRY_NS, self._flush_on, order=EventClass.BYTE, source=self.name)

    def _flush_on(self) -> None:
        self._flushing = False
        if not self.closed:
            self._flush()
