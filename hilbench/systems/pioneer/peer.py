"""The checker's own end of a P2OS line."""

from __future__ import annotations

from collections.abc import Iterator

from hilbench.bench.line_peer import QUIET_S, LinePeer, Sound, Unsound
from hilbench.clock import NS_PER_S
from hilbench.judging.recorder import unrecorded
from protocols.common.checksum import Checksum
from protocols.common.decoding import Decoder, NoOptions
from protocols.p2os import (
    Command,
    CommandNumber,
    Dropped,
    FrameReader,
    Identification,
    RemoteProtocolError,
    ServerPacket,
    Sip,
    SyncEcho,
    decode_packet,
    encode_command,
)
from protocols.p2os.decoding import checksum, decoder
from protocols.p2os.options import WATCHDOG_S

__all__ = ["QUIET_S", "REPLY_WITHIN_S", "SYNC0", "SYNC1", "SYNC2", "Peer"]

REPLY_WITHIN_S = 0.2
"""How soon an answer is due. No manual gives a figure; clients wait 0.4 to 1 s for an echo, and a robot that needs more
than two SIP cycles looks dead to them. A choice."""

SYNC0, SYNC1, SYNC2 = 0, 1, 2
"""Before a session the commands PULSE, OPEN and CLOSE mean this."""


class Peer(LinePeer[ServerPacket]):
    """See `LinePeer`."""

    REPLY_WITHIN_S = REPLY_WITHIN_S

    def checksum(self) -> Checksum:
        """See `LinePeer`."""
        return checksum(NoOptions())

    def _decoder(self, sent: bool) -> Decoder:
        return decoder(NoOptions(), "host" if sent else "target")

    def _begin_reading(self) -> None:
        self._reader = FrameReader()

    def _read(self, data: bytes, at_ns: int) -> Iterator[Sound[ServerPacket] | Unsound]:
        for item in self._reader.receive(data, at_ns):
            if isinstance(item, Dropped):
                yield Unsound(reason=item.reason.name, data=item.data)
                continue
            try:
                packet = decode_packet(item.body, connected=False)
            except RemoteProtocolError:
                packet = None
            yield Sound(raw=item.raw, packet=packet)

    # --- sending

    def send(self, number: int, argument: int | bytes | None = None) -> None:
        """Put a well-formed command on the line."""
        self.write(encode_command(Command(number=number, argument=argument)))

    def run_alive(self, duration_s: float, every_s: float = 0.5) -> None:
        """Let bench time pass while a PULSE every ``every_s`` seconds keeps the robot's watchdog fed."""
        begin_ns = self.bench.now_ns
        end_ns = begin_ns + round(duration_s * NS_PER_S)
        while self.bench.now_ns < end_ns:
            self.send(CommandNumber.PULSE)
            self.run(min(every_s, (end_ns - self.bench.now_ns) / NS_PER_S))
        self.require_punctual(begin_ns, WATCHDOG_S - every_s, "the watchdog may have run out")

    # --- looking back

    def sips(self, mark: int = 0) -> list[Sip]:
        """Return the SIPs received since ``mark``."""
        return [packet for _, packet in self.since(mark, Sip)]

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

    def stand_still(self) -> None:
        """Stop the robot."""
        self.send(CommandNumber.STOP)

    def settle(self) -> None:
        """Bring a real target back to where a case may begin: stopped, session closed, line quiet, input discarded."""
        if not self.wait_quiet(within_s=QUIET_S):
            for number, argument in ((CommandNumber.STOP, None), (CommandNumber.ENABLE, 0), (CommandNumber.CLOSE, 1)):
                self.send(number, argument)
                self.run(0.05)
            self.wait_quiet()
        self.forget()
