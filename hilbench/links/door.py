"""What the doors for foreign programs share: a line of its own between the program and the bench.

A program behind a pty or a socket writes whole chunks at once; a wire would not. So a door is two wires: what comes in
is let through at the baud rate from the moment it was seen, and what goes out leaves at the baud rate; at fast rates
some bytes together, for an entry for each is more than a processor takes. A client that leaves has hung up once its
last byte is through.

An emulated USART times its own frames, in the time of its chip, which runs ahead of the bench. A door that leads to one
hands over each byte when its start bit begins, in that time, and passes on what comes out as it comes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

from hilbench.clock import NS_PER_MS, EventClass, Scheduler
from hilbench.links.memory import REAL_TIME_GROUP_NS
from hilbench.links.port import Line, ModemLines, PortBase, Refused, raise_it
from hilbench.links.turns import Turns
from hilbench.links.uart import Timeline, Transmitter, resample

READ_BYTES = 4096
# Bytes that wait for the wire: beyond them the client is not read from (it feels that as flow control) and what the
# bench writes is refused and counted.
_WAITING_BYTES = 16 * 1024
# One system call for all bytes that end within a millisecond: one byte at 9600 baud, eleven at 115200.
_GROUP_NS = NS_PER_MS


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Input:
    """A descriptor and what to do when it is readable."""

    descriptor: int
    read: Callable[[int], None]

    def fileno(self) -> int:
        """Return the descriptor."""
        return self.descriptor

    def on_readable(self, at_ns: int) -> None:
        """Read it; `at_ns` is the bench time in ns."""
        self.read(at_ns)


class Door(PortBase, ABC):
    """A port whose other end is a program outside; see the subclasses.

    Args:
        scheduler: Owner of bench time, locked to the host's clock before it runs.
        name: For the journal and for messages.
        line: Baud rate of the wire, 0 for no pace.
        chip_time: Time of the chip whose USART the door leads to; None if it leads to anything else.
        any_baud: Understand a client whatever rate it has set.

    Attributes:
        on_garbled: Called with the client's rate in bit/s, once for each client, when it first sends at another rate
            than the line's.
        on_visit: Called with a sentence for people when a client comes while another one is there, and when one leaves
            while another one stays.
        turns: Whose turn it is to speak on the line behind; of several doors to one line, the same.
        hangs_up: Whether bytes of a client that are under way are lost when another one comes after him.
        number: Of this door among those of its bench, from 0 on.
        on_lines: Called with the levels of DTR and RTS that the client sets, True for asserted and None for one that
            is left, and the bench time in ns; of the doors, that of RFC 2217 alone knows.
    """

    KNOWS_BREAKS: ClassVar[bool] = False
    """Whether a client can be notified of a break, and can send one."""

    def __init__(
        self,
        scheduler: Scheduler,
        name: str,
        line: Line,
        chip_time: Timeline | None = None,
        *,
        any_baud: bool = False,
    ) -> None:
        super().__init__(name)
        self.any_baud = any_baud
        self.on_garbled: Callable[[int], None] = _ignore
        self.on_visit: Callable[[str], None] = _ignore_visit
        self.turns = Turns()
        self.hangs_up = True
        self.number = 0
        self.on_lines: Callable[[bool | None, bool | None, int], None] = _ignore_lines
        self._garbled = False
        self._scheduler = scheduler
        self._hung_up = False
        self._held: list[Input] = []  # of clients that are not read from: too much waits for the wire
        self._incoming = Transmitter(
            chip_time or scheduler,
            f"{name}.in",
            line,
            self._deliver,
            on_idle=self._drained if chip_time is None else self._drained_in_chip_time,
            at_start=chip_time is not None,
            on_break=self._break_in,
            group_ns=REAL_TIME_GROUP_NS if chip_time is None else 0,
        )
        self._out_has_pace = chip_time is None
        self._outgoing = Transmitter(
            scheduler,
            f"{name}.out",
            line if chip_time is None else Line(baud=0),
            self._speak,
            group_ns=_GROUP_NS,
            depth=_WAITING_BYTES,
            on_break=self._break_out,
        )

    @property
    def client_baud(self) -> int:
        """The rate that the client has set, bit/s; that of the line where it cannot set any."""
        return self.baud

    def follow(self, was_baud: int, *, unasked: bool) -> None:
        """Let a client that has set no rate have the line's, which was changed from `was_baud`.

        Args:
            was_baud: what it was before, bit/s.
            unasked: whether a client that is there takes it, too; one that comes later always begins with it.
        """

    @property
    def baud(self) -> int:
        """Bits per second of the wire, 0 for no pace."""
        return self._incoming.baud

    @baud.setter
    def baud(self, baud: int) -> None:
        self._incoming.baud = baud
        if self._out_has_pace:
            self._outgoing.baud = baud

    @property
    def incoming(self) -> Transmitter:
        """The client's end of the wire."""
        return self._incoming

    def tell_lines(self, lines: ModemLines) -> bool:  # noqa: ARG002 - a door of RFC 2217 alone can
        """Tell the client of the levels of CTS, DSR, RI and carrier behind the door; return whether it can be."""
        return False

    def set_frame(self, baud: int, bits_per_byte: int) -> None:
        """Let bytes from the client take so many bits each at a rate in bit/s, from the next on."""
        self._incoming.set_frame(baud, bits_per_byte)
        self.baud = baud

    def write(self, data: bytes) -> None:
        """Hand bytes to the wire. What finds nobody, or a client that does not read, is lost and counted."""
        self._take_to_send(data, self._scheduler.now_ns)
        self.counters.overruns += len(data) - self._outgoing.write(data)

    @property
    def pending(self) -> int:
        """Bytes written that have not left the wire."""
        return self._outgoing.pending

    def withdraw(self, keep: int) -> None:
        """Take back what has not left the wire, but for the next `keep` bytes and the one that is on it."""
        self.counters.withdrawn += self._outgoing.withdraw(keep)

    def send_break(self, duration_ns: int, _refused: Refused = raise_it) -> None:
        """Keep the wire busy for `duration_ns`, and tell the client when it is over.

        Raises:
            UnavailableError: a door of this kind knows no breaks; of all doors, that of RFC 2217 alone does.
        """
        if not self.KNOWS_BREAKS:
            self._refuse_break("this kind of endpoint has no breaks; one of RFC 2217 has")
        self._take_to_send(b"", self._scheduler.now_ns)
        self._outgoing.send_break(duration_ns)

    def disconnect(self) -> None:
        """Hang up on whoever is there; a client at a pseudo-terminal stays, for nobody can make it close."""

    def close(self) -> None:
        """Hang up and release everything; a second call does nothing."""
        if self.closed:
            return
        self.closed = True
        self.line_is_up = False
        self.turns.forget(self)
        self._incoming.clear()
        self.turns.is_silent(self)
        self.counters.lost += self._outgoing.clear()
        self._release()

    # --- for the subclass

    @abstractmethod
    def _put(self, data: bytes, at_ns: int) -> None:
        """Give bytes that left the wire to the client; count what it does not take."""

    @abstractmethod
    def _release(self) -> None:
        """Close descriptors."""

    def _speak(self, data: bytes, at_ns: int) -> None:
        self._scheduler.speak(self.number)
        self._put(data, at_ns)

    def _client_gone(self) -> None:
        """Learn that the client's last byte is through and the line is down."""

    def _break_in(self, _at_ns: int) -> None:
        """Learn that it is the turn of a break among the client's bytes."""

    def _break_out(self, _at_ns: int) -> None:
        """Learn that a break has left the wire."""

    def _in_order(self, at_ns: int, action: Callable[[], None]) -> None:
        """Have `action` happen at `at_ns`, after whatever was seen before."""
        self._scheduler.at(at_ns, action, order=EventClass.INPUT, source=self.name)

    def _came_in(self, source: Input, data: bytes, at_ns: int) -> None:
        """Take a chunk from the client that was seen at `at_ns`."""
        self._in_order(at_ns, partial(self._let_in, source, data))

    def _hear(self, source: Input, data: bytes, at_ns: int) -> None:
        """Take a chunk from the client, as the line hears it."""
        client_baud = self.client_baud
        if self._garbles(client_baud, self.baud) and not self._garbled:
            self._garbled = True
            self._in_order(at_ns, partial(self.on_garbled, client_baud))
        self._came_in(source, self._across(data, client_baud, self.baud), at_ns)

    def _across(self, data: bytes, sent_baud: int, own_baud: int) -> bytes:
        """Return what an end at `own_baud` gets of `data` sent at `sent_baud`."""
        if not self._garbles(sent_baud, own_baud):
            return data
        sampled = resample(data, sent_baud, own_baud)
        self.counters.framing_errors += sum(byte.framing_error for byte in sampled)
        return bytes(byte.value for byte in sampled)

    def _garbles(self, sent_baud: int, own_baud: int) -> bool:
        """Say whether two ends at these rates do not understand each other."""
        return not self.any_baud and sent_baud != own_baud and sent_baud > 0 and own_baud > 0

    def _client_came(self) -> None:
        """Put the line up; a former client whose bytes are still under way hangs up now."""
        if self._hung_up:
            self._hang_up_now()
        self._set_line(True, self._scheduler.now_ns)

    def _hang_up_now(self) -> None:
        """Put the line down, though bytes of the client may be under way."""
        if self.hangs_up:
            self._forget_incoming()
        self._hang_up()

    def _forget_incoming(self) -> None:
        """Let what is under way from the client be lost."""
        self.counters.lost += self.turns.forget(self) + self._incoming.clear()
        self.turns.is_silent(self)

    def _client_left(self) -> None:
        """Put the line down as soon as the client's bytes are through."""
        self._hung_up = self.line_is_up
        if self._hung_up and self._is_silent:
            self._hang_up()

    # --- the wire in

    def _let_in(self, source: Input, data: bytes) -> None:
        if self.closed:
            return
        self.turns.take(self, len(data), lambda: self._incoming.write(data))
        waiting = self._incoming.pending + sum(self.turns.waiting(self))
        if waiting > _WAITING_BYTES and self._scheduler.remove_source(source):
            self._held.append(source)

    def _drained(self, _at_ns: int) -> None:
        self.turns.is_silent(self)
        self._read_on()
        if self._hung_up and self._is_silent:
            self._hang_up()

    @property
    def _is_silent(self) -> bool:
        """Whether nothing from the client is under way."""
        return self._incoming.idle and not self.turns.waiting(self)

    def _drained_in_chip_time(self, at_ns: int) -> None:
        """Learn from a chip that is ahead of the bench that the last byte is through."""
        when_ns = max(at_ns, self._scheduler.now_ns)
        self._scheduler.at(when_ns, partial(self._drained_at_last, when_ns), order=EventClass.INPUT, source=self.name)

    def _drained_at_last(self, at_ns: int) -> None:
        if self._incoming.idle and not self.closed:
            self._drained(at_ns)

    def _read_on(self) -> None:
        for source in self._held:
            self._scheduler.add_source(source)
        self._held.clear()

    def _hang_up(self) -> None:
        self._hung_up = False
        self._read_on()
        self.counters.lost += self._outgoing.clear()  # the next client must not get the rest of it
        self._set_line(False, self._scheduler.now_ns)
        self._client_gone()


def _ignore_lines(_dtr: bool | None, _rts: bool | None, _at_ns: int) -> None:
    """Stand in for a callback that nobody has set."""


def _ignore_visit(_text: str) -> None:
    """Stand in for a callback that nobody has set."""


def _ignore(_baud: int) -> None:
    """Stand in for a callback that nobody has set."""
