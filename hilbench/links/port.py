"""What every end of a link has in common: the line it speaks, its counters, and how it tells its owner what happens."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NoReturn, Protocol

from hilbench.clock import NS_PER_MS, ClockDomain
from hilbench.errors import PortClosedError, UnavailableError

USUAL_BREAK_NS = NS_PER_MS
"""How long a break is held that is handed on where it is not known how long it was (choice)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """How bytes stand on the wire.

    Attributes:
        baud: Bits per second; 0 for a line without pace, where bytes arrive at once (in the next entry).
        data_bits: Data bits of a byte.
        parity: "N", "E" or "O".
        stop_bits: 1 or 2.
    """

    baud: int = 9600
    data_bits: int = 8
    parity: str = "N"
    stop_bits: int = 1

    def __post_init__(self) -> None:
        if self.baud < 0:
            raise ValueError(f"a line has 0 (no pace) or more baud, not {self.baud}")

    @property
    def bits_per_byte(self) -> int:
        """Bit times from the start bit to the end of the last stop bit: 10 for 8N1."""
        return 1 + self.data_bits + (self.parity != "N") + self.stop_bits

    def bytes_ns(self, count: int) -> int:
        """Return the time `count` bytes without gaps take, in ns; 0 on a line without pace."""
        return ClockDomain(self.baud).ns(count * self.bits_per_byte) if self.baud else 0


@dataclass(frozen=True, slots=True, kw_only=True)
class ModemLines:
    """The levels of the lines beside the data, True for asserted.

    Attributes:
        dtr: Ours to set, as `rts`.
        rts: See `dtr`.
        cts: The far end's, as all that follow.
        dsr: Data set ready.
        ri: Ring indicator.
        cd: Carrier.
    """

    dtr: bool
    rts: bool
    cts: bool
    dsr: bool
    ri: bool
    cd: bool

    @property
    def of_far_end(self) -> tuple[bool, bool, bool, bool]:
        """CTS, DSR, RI and carrier."""
        return self.cts, self.dsr, self.ri, self.cd


NO_LINE_ASSERTED = ModemLines(dtr=False, rts=False, cts=False, dsr=False, ri=False, cd=False)


@dataclass(slots=True, kw_only=True)
class LinkCounters:
    """What one end of a link has seen.

    Attributes:
        sent: Bytes handed to the line.
        received: Bytes that came off the line.
        lost: Bytes handed over that could not be delivered: line down, nobody reads, buffer full.
        withdrawn: Bytes handed over and taken back before they were sent.
        overruns: Bytes refused because the transmit queue was full.
        framing_errors: Bytes received without a stop bit where one was due.
        parity_errors: Bytes received with the wrong parity, where the driver of a real port counts them.
        receive_overruns: Bytes that a real port's UART or driver had no room for, as above.
        breaks: Break conditions received.
        breaks_unsent: Breaks asked for that this port cannot send.
        refused: Clients turned away.
    """

    sent: int = 0
    received: int = 0
    lost: int = 0
    withdrawn: int = 0
    overruns: int = 0
    framing_errors: int = 0
    parity_errors: int = 0
    receive_overruns: int = 0
    breaks: int = 0
    breaks_unsent: int = 0
    refused: int = 0


Refused = Callable[[UnavailableError], None]
"""Takes why something cannot be had that had to wait until the bytes before it were out."""


def raise_it(error: UnavailableError) -> None:
    """Stand in for somebody who is notified: the run ends."""
    raise error


class Port(Protocol):
    """One end of a link. Everything it reports, it reports from an entry of the scheduler.

    Attributes:
        name: For the journal and for messages.
        baud: Bits per second this end sends and listens with, 0 for no pace; may be set at any time and holds from
            the next byte on.
        line_is_up: Whether somebody is at the other end.
        comes_back: Whether a far end that is gone is looked for, and may come back.
        closed: Whether `close` was called.
        counters: What this end has seen.
        on_receive: Called with bytes as they come off the line and the bench time in ns of the last one's end.
        on_line: Called with True when the line comes up and False when it goes down, and the bench time in ns.
        on_break: Called when a break condition ends, with the bench time in ns.
        break_ns: How long the last break received was, in ns; 0 where that is not known.
        on_sent: Called with bytes when they are handed to the line, and the bench time in ns.
        on_modem: Called with the levels of the lines beside the data when the far end has changed one of them, and the
            bench time in ns; by ports that were told to watch them.
        on_refused: Called with a rate that cannot be had, and why, where the rate had to wait for the bytes before it;
            raises the latter unless somebody sets another.
    """

    name: str
    baud: int
    line_is_up: bool
    closed: bool
    comes_back: bool
    counters: LinkCounters
    on_receive: Callable[[bytes, int], None]
    on_line: Callable[[bool, int], None]
    on_break: Callable[[int], None]
    break_ns: int
    on_sent: Callable[[bytes, int], None]
    on_modem: Callable[[ModemLines, int], None]
    on_refused: Callable[[int, UnavailableError], None]

    def write(self, data: bytes) -> None:
        """Hand bytes to the line; never blocks. PortClosedError after `close`."""

    @property
    def pending(self) -> int:
        """Bytes handed over that are not out yet; 0 where that cannot be known."""

    def withdraw(self, keep: int) -> None:
        """Take back what is not out yet, but for the next `keep` bytes; nothing where that cannot be done."""

    def send_break(self, duration_ns: int, refused: Refused = raise_it) -> None:
        """Hold the line low for `duration_ns`, after the bytes handed over so far; lost where nobody is there.

        Args:
            duration_ns: for how long, in ns.
            refused: notified if it shows only when those bytes are out that there cannot be a break.

        Raises:
            UnavailableError: a break cannot be sent here, as at a pseudo-terminal and a socket.
        """

    @property
    def modem_lines(self) -> ModemLines | None:
        """The levels of the lines beside the data; None on a port that has none."""

    def set_lines(self, *, dtr: bool | None = None, rts: bool | None = None) -> None:
        """Set DTR and RTS, True for asserted; None leaves one as it is.

        Raises:
            UnavailableError: this port has no such lines, as one in memory, a pseudo-terminal or a socket; or it is
                gone. Nothing has changed then.
        """

    def close(self) -> None:
        """Hang up and release everything; a second call does nothing."""


def _ignore_bytes(_data: bytes, _at_ns: int) -> None:
    """Stand in for a callback that nobody has set."""


def _ignore_line(_up: bool, _at_ns: int) -> None:
    """Stand in for a callback that nobody has set."""


def _ignore_break(_at_ns: int) -> None:
    """Stand in for a callback that nobody has set."""


def _ignore_modem(_lines: ModemLines, _at_ns: int) -> None:
    """Stand in for a callback that nobody has set."""


def _raise(_baud: int, error: UnavailableError) -> None:
    raise error


class PortBase:
    """The part of a port that is the same everywhere."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.line_is_up = False
        self.closed = False
        self.comes_back = False
        self.counters = LinkCounters()
        self.on_receive: Callable[[bytes, int], None] = _ignore_bytes
        self.on_line: Callable[[bool, int], None] = _ignore_line
        self.on_break: Callable[[int], None] = _ignore_break
        self.break_ns = 0
        self.on_sent: Callable[[bytes, int], None] = _ignore_bytes
        self.on_modem: Callable[[ModemLines, int], None] = _ignore_modem
        self.on_refused: Callable[[int, UnavailableError], None] = _raise

    @property
    def pending(self) -> int:
        """Bytes handed over that are not out yet; 0 where that cannot be known."""
        return 0

    def withdraw(self, keep: int) -> None:
        """Take back what is not out yet, but for the next `keep` bytes; nothing where that cannot be done."""

    @property
    def modem_lines(self) -> ModemLines | None:
        """The levels of the lines beside the data; None on a port that has none."""
        return None

    def set_lines(self, *, dtr: bool | None = None, rts: bool | None = None) -> None:  # noqa: ARG002 - none is there
        """Set DTR and RTS; see `Port.set_lines`.

        Raises:
            UnavailableError: this port has no such lines, or is gone.
        """
        raise UnavailableError("this line has no DTR and RTS", where=self.name)

    def _refuse_break(self, reason: str) -> NoReturn:
        """Count a break that this port cannot send, and say why it cannot."""
        self.counters.breaks_unsent += 1
        raise UnavailableError(f"a break cannot be sent: {reason}", where=self.name)

    def _take_to_send(self, data: bytes, at_ns: int) -> None:
        """Count and report bytes that the owner writes."""
        if self.closed:
            raise PortClosedError("written to after it was closed", where=self.name)
        self.counters.sent += len(data)
        self.on_sent(data, at_ns)

    def _deliver(self, data: bytes, at_ns: int) -> None:
        """Count and report bytes that came off the line."""
        if self.closed:
            return
        self.counters.received += len(data)
        self.on_receive(data, at_ns)

    def _set_line(self, up: bool, at_ns: int) -> None:
        """Report a change of the line, once."""
        if up != self.line_is_up:
            self.line_is_up = up
            if not self.closed:
                self.on_line(up, at_ns)
