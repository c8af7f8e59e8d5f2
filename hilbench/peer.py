"""The checker's own end of a P2OS line: writes what a case wants, keeps everything that comes back with its time.

It is deliberately not a client: it starts nothing by itself, sends wrong things when told to, and has no opinion about
what it receives. Judging is the business of the case.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from hilbench.bench import Bench
from hilbench.check.judge import at_most
from hilbench.check.recorder import unrecorded
from hilbench.check.verdicts import Violation
from hilbench.clock import NS_PER_S
from hilbench.errors import UnavailableError
from hilbench.links import Port
from protocols.p2os import (
    Command,
    CommandNumber,
    Dropped,
    Frame,
    FrameReader,
    Identification,
    RemoteProtocolError,
    ServerPacket,
    Sip,
    SyncEcho,
    decode_packet,
    encode_command,
)

PacketT = TypeVar("PacketT")

REPLY_WITHIN_S = 0.2
"""How soon an answer is due. No manual gives a figure; clients wait 0.4 to 1 s for an echo, and a robot that needs more
than two SIP cycles looks dead to them. A choice."""

SYNC0, SYNC1, SYNC2 = 0, 1, 2
"""Before a session the commands PULSE, OPEN and CLOSE mean this."""

QUIET_S = 0.25
"""A line with nothing on it for this long, two and a half SIP cycles, is quiet. A choice."""

_EVIDENCE_PACKETS = 6
_KEPT_BYTE_TIMES = 1024


@dataclass(frozen=True, slots=True, kw_only=True)
class Received:
    """A packet as it came off the line.

    Attributes:
        start_ns: bench time at which its first byte was complete.
        at_ns: bench time at which its last byte was complete.
        raw: the packet from header to checksum.
        packet: what it says; None if its body could not be decoded.
    """

    start_ns: int
    at_ns: int
    raw: bytes
    packet: ServerPacket | None


class Peer:
    """One end of a P2OS line in the hands of a check.

    Args:
        bench: whose time passes while the peer waits.
        port: the line.

    Attributes:
        line_expected: whether a line that is down means that the target is gone; a case that hangs up clears it.
    """

    def __init__(self, bench: Bench, port: Port) -> None:
        self.bench = bench
        self.received: list[Received] = []
        self.dropped: list[Dropped] = []
        self.bytes_received = 0
        self._reader = FrameReader()
        self._byte_times_ns: deque[int] = deque(maxlen=_KEPT_BYTE_TIMES)
        self.line_expected = True
        self.attach(port)

    # --- sending

    def write(self, data: bytes) -> None:
        """Put raw bytes on the line, as they are."""
        self.bench.record("tx", "checker", data=data)
        self.port.write(data)

    def send(self, number: int, argument: int | bytes | None = None) -> None:
        """Put a well-formed command on the line."""
        self.write(encode_command(Command(number=number, argument=argument)))

    def run(self, duration_s: float) -> None:
        """Let bench time pass, in seconds."""
        self.bench.run_for(duration_s)
        self.require_line()

    def run_alive(self, duration_s: float, every_s: float = 0.5) -> None:
        """Let bench time pass while a PULSE every ``every_s`` seconds keeps the robot's watchdog fed."""
        end_ns = self.bench.now_ns + round(duration_s * NS_PER_S)
        while self.bench.now_ns < end_ns:
            self.send(CommandNumber.PULSE)
            self.run(min(every_s, (end_ns - self.bench.now_ns) / NS_PER_S))

    # --- looking back

    def mark(self) -> int:
        """Return a position in what was received, to look only at what comes after it."""
        return len(self.received)

    def since(self, mark: int, kind: type[PacketT]) -> list[tuple[Received, PacketT]]:
        """Return the packets of a kind received since ``mark``, each with how it was received."""
        return [(got, got.packet) for got in self.received[mark:] if isinstance(got.packet, kind)]

    def sips(self, mark: int = 0) -> list[Sip]:
        """Return the SIPs received since ``mark``."""
        return [packet for _, packet in self.since(mark, Sip)]

    @property
    def last_sip(self) -> Sip:
        """The newest SIP.

        Raises:
            Violation: there was none.
        """
        for got in reversed(self.received):
            if isinstance(got.packet, Sip):
                return got.packet
        raise Violation("no SIP was received", self.evidence())

    def evidence(self, mark: int | None = None) -> Sequence[str]:
        """Return the latest packets (those since ``mark``) and what was dropped, as lines for a report."""
        shown = self.received[-_EVIDENCE_PACKETS:] if mark is None else self.received[mark:][-_EVIDENCE_PACKETS:]
        lines = [f"{got.at_ns / NS_PER_S:10.4f} s  {got.raw.hex(' ').upper()}" for got in shown]
        lines += [f"dropped ({drop.reason.name})  {drop.data[:32].hex(' ').upper()}" for drop in self.dropped[-2:]]
        return lines or [f"nothing received ({self.bytes_received} bytes in all)"]

    def uncertainty_s(self, since_ns: int) -> float:
        """Return how far off times on this bench may be, over what happened since ``since_ns``; see `Bench`."""
        return self.bench.uncertainty_s(since_ns)

    # --- waiting

    def expect(
        self,
        kind: type[PacketT],
        within_s: float = REPLY_WITHIN_S,
        *,
        where: Callable[[PacketT], bool] | None = None,
        what: str = "",
        mark: int | None = None,
    ) -> PacketT:
        """Wait for a packet of a kind, and require it to be in time.

        Args:
            kind: the class of packet.
            within_s: how soon, in seconds of bench time from now, its last byte is due.
            where: what else must hold for it.
            what: what to call it in a report.
            mark: from where on to look; by default only what comes from now on.

        Raises:
            Violation: none came in time.
            Inconclusive: it came so close to the limit that the bench cannot tell.
        """
        name = what or kind.__name__
        start_ns = self.bench.now_ns
        position = first = self.mark() if mark is None else mark
        found: list[tuple[int, PacketT]] = []

        def arrived() -> bool:
            nonlocal position
            while position < len(self.received) and not found:
                got = self.received[position]
                position += 1
                if isinstance(got.packet, kind) and (where is None or where(got.packet)):
                    found.append((got.at_ns, got.packet))
            return bool(found)

        # Waiting a little beyond the limit tells late from never.
        if not self.bench.run_until(arrived, within_s * 1.5 + 0.05):
            self.require_line()
            raise Violation(f"no {name} within {within_s:g} s", self.evidence(first))
        at_ns, packet = found[0]
        elapsed_s = max(0, at_ns - start_ns) / NS_PER_S
        at_most(elapsed_s, within_s, unit="s", what=f"{name} came after", uncertainty=self.uncertainty_s(start_ns))
        return packet

    def expect_silence(self, for_s: float, *, why: str = "") -> None:
        """Require that nothing at all comes for ``for_s`` seconds.

        Raises:
            Violation: a byte came.
        """
        mark, count, start_ns = self.mark(), self.bytes_received, self.bench.now_ns
        self.run(for_s)
        if self.bytes_received != count:
            after_s = (self._byte_times_ns[-1] - start_ns) / NS_PER_S
            raise Violation(
                f"{self.bytes_received - count} bytes came (the last after {after_s:.3f} s) where silence is required"
                + (f": {why}" if why else ""),
                self.evidence(mark),
            )

    def wait_quiet(self, for_s: float = QUIET_S, within_s: float = 2.0) -> bool:
        """Let time pass until nothing has come for ``for_s`` seconds; say whether that was so within ``within_s``."""
        end_ns = self.bench.now_ns + round(within_s * NS_PER_S)
        while self.bench.now_ns < end_ns:
            count = self.bytes_received
            self.run(for_s)
            if self.bytes_received == count:
                return True
        return False

    # --- the usual beginnings and ends

    def sync(self, number: int) -> SyncEcho | Identification:
        """Send SYNC0, SYNC1 or SYNC2 and wait for its answer."""
        self.send(number)
        if number == SYNC2:
            return self.expect(Identification)
        return self.expect(SyncEcho, where=lambda echo: echo.number == number, what=f"echo of SYNC{number}")

    def handshake(self) -> Identification:
        """Go through SYNC0, SYNC1 and SYNC2.

        Raises:
            Violation: an answer is missing.
        """
        with unrecorded():
            self.sync(SYNC0)
            self.sync(SYNC1)
            identification = self.sync(SYNC2)
        assert isinstance(identification, Identification)
        return identification

    def start(self) -> Sip:
        """Open a session and wait for its first SIP."""
        self.handshake()
        self.send(CommandNumber.OPEN)
        with unrecorded():
            return self.expect(Sip, what="first SIP")

    def start_with_motors(self) -> Sip:
        """Open a session, enable the motors and wait until a SIP says so."""
        self.start()
        self.send(CommandNumber.ENABLE, 1)
        with unrecorded():
            return self.expect(Sip, 0.3, where=lambda sip: sip.motors_enabled, what="SIP with motors enabled")

    def settle(self) -> None:
        """Bring a real target back to where a case may begin: stopped, session closed, line quiet, input discarded."""
        if not self.wait_quiet(within_s=QUIET_S):
            for number, argument in ((CommandNumber.STOP, None), (CommandNumber.ENABLE, 0), (CommandNumber.CLOSE, 1)):
                self.send(number, argument)
                self.run(0.05)
            self.wait_quiet()
        self.forget()

    def forget(self) -> None:
        """Discard everything received so far."""
        self._reader = FrameReader()
        self.received.clear()
        self.dropped.clear()
        self.bytes_received = 0

    # --- the line

    def attach(self, port: Port) -> None:
        """Use another port from now on."""
        self.port = port
        self.line_expected = True
        self._reader = FrameReader()
        port.on_receive = self._take
        port.on_line = self._line_changed

    def require_line(self) -> None:
        """Raise UnavailableError if the far end has gone away by itself."""
        if self.line_expected and not self.port.line_is_up:
            raise UnavailableError("the target closed the line", where=self.port.name)

    def _take(self, data: bytes, at_ns: int) -> None:
        # One byte at a time, so that each packet knows when its first byte came.
        for index in range(len(data)):
            self.bytes_received += 1
            self._byte_times_ns.append(at_ns)
            for item in self._reader.receive(data[index : index + 1], at_ns):
                self._keep(item, at_ns)

    def _keep(self, item: Frame | Dropped, at_ns: int) -> None:
        if isinstance(item, Dropped):
            self.dropped.append(item)
            self.bench.record("dropped", "checker", reason=item.reason.name, data=item.data)
            return
        first = min(len(item.raw), len(self._byte_times_ns))
        try:
            packet = decode_packet(item.body, connected=False)
        except RemoteProtocolError:
            packet = None
        self.bench.record("rx", "checker", data=item.raw, packet=type(packet).__name__)
        self.received.append(Received(start_ns=self._byte_times_ns[-first], at_ns=at_ns, raw=item.raw, packet=packet))

    def _line_changed(self, up: bool, _at_ns: int) -> None:
        self.bench.record("line", "checker", up=up)
