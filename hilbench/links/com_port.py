"""The access server's side of the Telnet Com Port Control Option, without I/O (RFC 2217).

A client that agrees on the option sets the rate of a far serial port, its lines and breaks. The line behind it here is
8N1 without flow control: another form of a byte, or flow control, is answered with what holds, which is how the option
refuses (section 3). DTR and RTS are kept, answered, and reported to whoever is behind the door. CTS, DSR, RI and
carrier are reported as they are behind the door; where nothing there knows, all but RI are asserted, as on a cable that
joins them at its own end (choice).
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

from hilbench.links.port import ModemLines
from hilbench.links.telnet import Data, Negotiation, Subnegotiation, TelnetDecoder, Verb, negotiation, subnegotiation

__all__ = [
    "COM_PORT",
    "JOINED",
    "BreakSet",
    "Bytes",
    "ComPortEvent",
    "ComPortServer",
    "HeldBack",
    "LinesSet",
    "Purged",
    "RateSet",
]

BINARY, SUPPRESS_GO_AHEAD, COM_PORT = 0, 3, 44
_SUPPORTED = frozenset({BINARY, SUPPRESS_GO_AHEAD, COM_PORT})

_SIGNATURE, _SET_BAUDRATE, _SET_DATASIZE, _SET_PARITY, _SET_STOPSIZE, _SET_CONTROL = range(6)
_NOTIFY_LINESTATE, _NOTIFY_MODEMSTATE, _SUSPEND, _RESUME, _LINE_MASK, _MODEM_MASK, _PURGE = range(6, 13)
_ANSWER = 100
"""What the server says bears the client's number plus this."""

_EIGHT_BITS, _NO_PARITY, _ONE_STOP_BIT = 8, 1, 1
_BREAK_DETECTED = 0x10
_CTS, _DSR, _RI, _CARRIER = 0x10, 0x20, 0x40, 0x80
_CTS_CHANGED, _DSR_CHANGED, _RI_ENDED, _CARRIER_CHANGED = 0x01, 0x02, 0x04, 0x08
JOINED = ModemLines(dtr=True, rts=True, cts=True, dsr=True, ri=False, cd=True)
"""What a cable tells that joins the lines of one end with each other."""

# SET-CONTROL: what is asked, and what the answer is where nothing else can hold.
_NO_FLOW_CONTROL, _NO_INBOUND_FLOW_CONTROL = 1, 14
_OUTBOUND = frozenset({0, 1, 2, 3, 17, 19})
_INBOUND = frozenset({13, 14, 15, 16, 18})
_ASK_BREAK, _BREAK_ON, _BREAK_OFF = 4, 5, 6
_ASK_DTR, _DTR_ON, _DTR_OFF = 7, 8, 9
_ASK_RTS, _RTS_ON, _RTS_OFF = 10, 11, 12


@dataclass(frozen=True, slots=True)
class Bytes:
    """What the client sends on the line."""

    data: bytes


@dataclass(frozen=True, slots=True)
class RateSet:
    """The rate the client speaks at, bit/s."""

    baud: int


@dataclass(frozen=True, slots=True)
class BreakSet:
    """The client holds the line low, or lets it go."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class LinesSet:
    """The client sets DTR or RTS, True for asserted; None for the one that is left as it is."""

    dtr: bool | None = None
    rts: bool | None = None


@dataclass(frozen=True, slots=True)
class Purged:
    """What the client has sent and is not on the line yet is to be forgotten."""


@dataclass(frozen=True, slots=True)
class HeldBack:
    """The client wants to get nothing for a while, or again."""

    on: bool


ComPortEvent = Bytes | RateSet | BreakSet | LinesSet | Purged | HeldBack


class _Option(enum.Enum):
    """Whether an option is in force for one end."""

    NO = enum.auto()
    ASKED = enum.auto()
    """We have offered it or asked for it, and wait for the answer, which is not to be answered."""
    YES = enum.auto()


class ComPortServer:
    """One client's session.

    Args:
        baud: rate of the line before the client sets it, bit/s.
        lines: the lines beside the data of what is behind.

    Attributes:
        baud: rate that the client has set.
        dtr: level of DTR.
        rts: level of RTS.
        agreed: whether the client has agreed on the option.
        answers: bytes to be sent to the client; whoever sends them clears it.
    """

    def __init__(self, baud: int, lines: ModemLines = JOINED) -> None:
        self.baud = baud
        self.dtr = self.rts = True
        self.agreed = False
        self._line_mask = 0
        self._modem_mask = 0xFF
        self._modem_state = _state_of(lines)
        self._breaking = False
        self._decoder = TelnetDecoder()
        self._ours = {BINARY: _Option.ASKED, SUPPRESS_GO_AHEAD: _Option.ASKED}
        self._theirs = {BINARY: _Option.ASKED}
        self.answers = bytearray(negotiation(Verb.WILL, BINARY) + negotiation(Verb.DO, BINARY))
        self.answers += negotiation(Verb.WILL, SUPPRESS_GO_AHEAD)

    def receive(self, data: bytes) -> list[ComPortEvent]:
        """Take bytes from the client; return what it wants, in order."""
        wanted: list[ComPortEvent] = []
        for event in self._decoder.feed(data):
            match event:
                case Data(data=line):
                    wanted.append(Bytes(line))
                case Negotiation(verb=verb, option=option):
                    self._negotiate(verb, option)
                case Subnegotiation(option=option, payload=payload) if option == COM_PORT and payload:
                    wanted += self._obey(payload[0], payload[1:])
        return wanted

    def tell_break(self) -> None:
        """Tell the client that the line behind was held low, if it wants to know."""
        if self._line_mask & _BREAK_DETECTED:
            self._answer(_NOTIFY_LINESTATE, bytes((_BREAK_DETECTED,)))

    def tell_lines(self, lines: ModemLines) -> None:
        """Tell the client how the lines behind are now, as far as they have changed and it wants to know."""
        before, self._modem_state = self._modem_state, _state_of(lines)
        notice = (self._modem_state | _changes(before, self._modem_state)) & self._modem_mask
        if self.agreed and before != self._modem_state and notice:
            self._answer(_NOTIFY_MODEMSTATE, bytes((notice,)))

    # --- options

    def _negotiate(self, verb: Verb, option: int) -> None:
        """Answer what changes something, and nothing else: two ends that answer everything never end (RFC 1143)."""
        about_us = verb in (Verb.DO, Verb.DONT)
        options = self._ours if about_us else self._theirs
        yes, no = (Verb.WILL, Verb.WONT) if about_us else (Verb.DO, Verb.DONT)
        state = options.get(option, _Option.NO)
        if verb in (Verb.DONT, Verb.WONT):
            options[option] = _Option.NO
            if state is _Option.YES:
                self.answers += negotiation(no, option)
        elif option not in _SUPPORTED:
            self.answers += negotiation(no, option)
        else:
            options[option] = _Option.YES
            if state is _Option.NO:
                self.answers += negotiation(yes, option)
            if option == COM_PORT and not self.agreed:
                self.agreed = True
                self._answer_lines()

    def _answer(self, command: int, payload: bytes) -> None:
        self.answers += subnegotiation(COM_PORT, bytes((command + _ANSWER,)) + payload)

    def _answer_lines(self) -> None:
        self._answer(_NOTIFY_MODEMSTATE, bytes((self._modem_state & self._modem_mask,)))

    # --- commands

    def _obey(self, command: int, payload: bytes) -> list[ComPortEvent]:
        if command == _SIGNATURE and not payload:
            self._answer(_SIGNATURE, b"hilbench")
        elif command == _NOTIFY_MODEMSTATE:  # pyserial's client asks so for it
            self._answer_lines()
        elif command == _SET_BAUDRATE and len(payload) == 4:
            return self._set_baud(int.from_bytes(payload, "big"))
        elif command in _FIXED:
            self._answer(command, bytes((_FIXED[command],)))
        elif command in (_SUSPEND, _RESUME):
            return [HeldBack(command == _SUSPEND)]
        elif len(payload) == 1:
            return self._obey_byte(command, payload[0])
        return []

    def _obey_byte(self, command: int, value: int) -> list[ComPortEvent]:
        if command == _SET_CONTROL:
            return self._control(value)
        if command == _LINE_MASK:
            self._line_mask = value
            self._answer(command, bytes((value,)))
        elif command == _MODEM_MASK:
            self._modem_mask = value
            self._answer(command, bytes((value,)))
        elif command == _PURGE:
            self._answer(command, bytes((value,)))
            return [Purged()] if value in (2, 3) else []
        return []

    def _set_baud(self, baud: int) -> list[ComPortEvent]:
        """Set the rate; 0 asks for it."""
        if baud:
            self.baud = baud
        self._answer(_SET_BAUDRATE, self.baud.to_bytes(4, "big"))
        return [RateSet(baud)] if baud else []

    def _control(self, value: int) -> list[ComPortEvent]:
        wanted: list[ComPortEvent] = []
        if value in _OUTBOUND:
            value = _NO_FLOW_CONTROL
        elif value in _INBOUND:
            value = _NO_INBOUND_FLOW_CONTROL
        elif value in (_ASK_BREAK, _BREAK_ON, _BREAK_OFF):
            value = self._break(value, wanted)
        elif value in (_ASK_DTR, _DTR_ON, _DTR_OFF, _ASK_RTS, _RTS_ON, _RTS_OFF):
            value = self._lines(value, wanted)
        else:
            return []
        self._answer(_SET_CONTROL, bytes((value,)))
        return wanted

    def _break(self, value: int, wanted: list[ComPortEvent]) -> int:
        if value != _ASK_BREAK and (value == _BREAK_ON) != self._breaking:
            self._breaking = not self._breaking
            wanted.append(BreakSet(self._breaking))
        return _BREAK_ON if self._breaking else _BREAK_OFF

    def _lines(self, value: int, wanted: list[ComPortEvent]) -> int:
        if value in (_DTR_ON, _DTR_OFF):
            self.dtr = value == _DTR_ON
            wanted.append(LinesSet(dtr=self.dtr))
        elif value in (_RTS_ON, _RTS_OFF):
            self.rts = value == _RTS_ON
            wanted.append(LinesSet(rts=self.rts))
        if value in (_ASK_DTR, _DTR_ON, _DTR_OFF):
            return _DTR_ON if self.dtr else _DTR_OFF
        return _RTS_ON if self.rts else _RTS_OFF


def _state_of(lines: ModemLines) -> int:
    """Return levels as bits of the option."""
    bits = zip(lines.of_far_end, (_CTS, _DSR, _RI, _CARRIER), strict=True)
    return sum(bit for level, bit in bits if level)


def _changes(before: int, now: int) -> int:
    """Return the bits of the option that tell of changes: of RI, that it has fallen."""
    changed = before ^ now
    reported = {_CTS: _CTS_CHANGED, _DSR: _DSR_CHANGED, _RI & before: _RI_ENDED, _CARRIER: _CARRIER_CHANGED}
    return sum(bit for line, bit in reported.items() if changed & line)


_FIXED = {_SET_DATASIZE: _EIGHT_BITS, _SET_PARITY: _NO_PARITY, _SET_STOPSIZE: _ONE_STOP_BIT}
"""What cannot be set: the command, and what holds."""
