"""The part of Telnet that a serial port over a network needs, without I/O (RFC 854, RFC 855).

Bytes in, events out; nothing that comes can raise an exception. Data is taken as it is, whatever is negotiated: the CR
NUL of a Network Virtual Terminal is two bytes here (choice: clients of RFC 2217 negotiate binary transmission, RFC
856).
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

__all__ = [
    "LONGEST_SUBNEGOTIATION",
    "Data",
    "Event",
    "Negotiation",
    "Subnegotiation",
    "TelnetDecoder",
    "Verb",
    "escape",
    "negotiation",
    "subnegotiation",
]

LONGEST_SUBNEGOTIATION = 1024
"""What is longer is dropped (choice); the longest of RFC 2217 is a signature."""

_IAC = 255
_SE = 240
_SB = 250


class Verb(enum.IntEnum):
    """What is said of an option (RFC 854)."""

    WILL = 251
    WONT = 252
    DO = 253
    DONT = 254


_VERBS = frozenset(Verb)


@dataclass(frozen=True, slots=True)
class Data:
    """Bytes of the line."""

    data: bytes


@dataclass(frozen=True, slots=True)
class Negotiation:
    """An option is offered, asked for, or refused."""

    verb: Verb
    option: int


@dataclass(frozen=True, slots=True)
class Subnegotiation:
    """What is said within an option."""

    option: int
    payload: bytes


Event = Data | Negotiation | Subnegotiation


def escape(data: bytes) -> bytes:
    """Return data as it stands on the wire."""
    return data.replace(b"\xff", b"\xff\xff")


def negotiation(verb: Verb, option: int) -> bytes:
    """Return a negotiation as it stands on the wire."""
    return bytes((_IAC, verb, option))


def subnegotiation(option: int, payload: bytes) -> bytes:
    """Return a subnegotiation as it stands on the wire."""
    return bytes((_IAC, _SB, option)) + escape(payload) + bytes((_IAC, _SE))


class _State(enum.Enum):
    DATA = enum.auto()
    COMMAND = enum.auto()
    """Behind IAC."""
    OPTION = enum.auto()
    """Behind a verb."""
    INSIDE = enum.auto()
    """Within a subnegotiation."""
    INSIDE_COMMAND = enum.auto()
    """Behind IAC within one."""


class TelnetDecoder:
    """Takes a stream apart, however it is cut.

    Attributes:
        dropped: subnegotiations that were too long, or not ended as they should.
    """

    def __init__(self) -> None:
        self.dropped = 0
        self._state = _State.DATA
        self._verb = Verb.WILL
        self._inside = bytearray()
        self._events: list[Event] = []

    def feed(self, data: bytes) -> list[Event]:
        """Take bytes; return what they say, in order."""
        self._events = []
        at = 0
        while at < len(data):
            if self._state in (_State.DATA, _State.INSIDE):
                at = self._take_run(data, at)
            else:
                self._step(data[at])
                at += 1
        return self._events

    def _take_run(self, data: bytes, at: int) -> int:
        """Take all up to the next IAC, and the IAC."""
        end = data.find(_IAC, at)
        run = data[at:] if end < 0 else data[at:end]
        if self._state is _State.INSIDE:
            self._inside += run[: LONGEST_SUBNEGOTIATION + 2 - len(self._inside)]
        elif run:
            self._add(run)
        if end < 0:
            return len(data)
        self._state = _State.INSIDE_COMMAND if self._state is _State.INSIDE else _State.COMMAND
        return end + 1

    def _step(self, value: int) -> None:
        if self._state is _State.OPTION:
            self._events.append(Negotiation(self._verb, value))
            self._state = _State.DATA
        elif self._state is _State.INSIDE_COMMAND and value == _IAC:
            self._inside += b"\xff"[: LONGEST_SUBNEGOTIATION + 2 - len(self._inside)]
            self._state = _State.INSIDE
        elif self._state is _State.INSIDE_COMMAND and value == _SE:
            self._end_subnegotiation()
        else:
            if self._state is _State.INSIDE_COMMAND:
                self.dropped += 1  # a command within: its end was lost
            self._command(value)

    def _command(self, value: int) -> None:
        self._state = _State.DATA
        if value == _IAC:
            self._add(b"\xff")
        elif value == _SB:
            self._inside.clear()
            self._state = _State.INSIDE
        elif value in _VERBS:
            self._verb = Verb(value)
            self._state = _State.OPTION

    def _end_subnegotiation(self) -> None:
        self._state = _State.DATA
        if 1 <= len(self._inside) <= LONGEST_SUBNEGOTIATION + 1:
            self._events.append(Subnegotiation(self._inside[0], bytes(self._inside[1:])))
        else:
            self.dropped += 1

    def _add(self, data: bytes) -> None:
        """Add data to that just before it, if there is any."""
        last = self._events[-1] if self._events else None
        if isinstance(last, Data):
            self._events[-1] = Data(last.data + data)
        else:
            self._events.append(Data(data))
