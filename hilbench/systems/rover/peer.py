"""The checker's own end of a PKT! line, with the rover at the other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from hilbench.bench import Bench
from hilbench.bench.line_peer import LinePeer, Sound, Unsound
from hilbench.links import Port
from protocols.common.checksum import Checksum
from protocols.common.decoding import Decoder
from protocols.pkt import (
    ClientOptions,
    Command,
    Dropped,
    FrameReader,
    Framing,
    GeneralReport,
    LedOff,
    MotorSpeeds,
    MotorThrottles,
    PidGains,
    Profile,
    RemoteProtocolError,
    Report,
    RequestTelemetry,
    Schema,
    decode_report,
    encode_command,
    encode_frame,
    longest_frame,
)
from protocols.pkt.decoding import DecodeOptions, checksum, decoder

__all__ = ["READY_WITHIN_S", "RoverPeer"]

REPLY_WITHIN_S = 0.2
"""How soon an answer is due. No source gives a figure; the firmware looks for commands every 10 ms. A choice."""

READY_WITHIN_S = 5.0
"""How long a rover may take from power-on to its first answer. A choice; the published firmware sleeps for 1 s."""

_ASK_EVERY_S = 0.25
_LAST_ANSWERS_S = 0.1
_FLUSH = b"\n"
_GAINS = PidGains(kp=0.01, kd=0.0001, ki=0.0001)
"""What the manual says the gains are at power-up."""


class RoverPeer(LinePeer[Report]):
    """See `LinePeer`.

    Args:
        bench: whose time passes while the peer waits.
        port: the line.
        profile: what the rover is to be spoken to in.
    """

    REPLY_WITHIN_S = REPLY_WITHIN_S

    def __init__(self, bench: Bench, port: Port, profile: Profile) -> None:
        self.profile = profile
        super().__init__(bench, port)

    @property
    def _options(self) -> DecodeOptions:
        return DecodeOptions(framing=self.profile.server.frames.framing, schema=self.profile.server.schema)

    def checksum(self) -> Checksum:
        """See `LinePeer`."""
        return checksum(self._options)

    def _decoder(self, sent: bool) -> Decoder:
        return decoder(self._options, "host" if sent else "target")

    def _begin_reading(self) -> None:
        frames = self.profile.server.frames
        # Without a length byte a newline may stand in payload or CRC: the check must not lose what it judges.
        tolerant = frames.framing is Framing.TERM
        self._reader = FrameReader(replace(ClientOptions().frames, framing=frames.framing, tolerant_newline=tolerant))

    def _read(self, data: bytes, at_ns: int) -> Iterator[Sound[Report] | Unsound]:
        for item in self._reader.receive(data, at_ns):
            if isinstance(item, Dropped):
                yield Unsound(reason=item.reason.name, data=item.data)
                continue
            try:
                report = decode_report(item.payload, self.profile.server.schema)
            except RemoteProtocolError:
                report = None
            yield Sound(raw=item.raw, packet=report)

    # --- sending

    def frame(self, payload: bytes) -> bytes:
        """Return a sound frame around a payload, in the rover's framing."""
        return encode_frame(payload, self.profile.server.frames)

    def frame_of(self, command: Command) -> bytes:
        """Return the frame of a command."""
        return self.frame(encode_command(command, self.profile.server.schema))

    def send(self, command: Command) -> None:
        """Put a well-formed command on the line."""
        self.write(self.frame_of(command))

    def request(self) -> GeneralReport:
        """Ask for the general report, and return it.

        Raises:
            Violation: none came in time.
        """
        self.send(RequestTelemetry())
        return self.expect(GeneralReport, what="0x80 on request")

    def line_s(self, size: int) -> float:
        """Return how long so many bytes take on the line, in seconds."""
        return 10 * size / self.port.baud if self.port.baud else 0.0

    # --- the usual beginnings and ends

    def wait_ready(self) -> bool:
        """Ask until the rover answers; say whether it did."""
        mark = self.mark()
        for _ in range(round(READY_WITHIN_S / _ASK_EVERY_S)):
            self.send(RequestTelemetry())
            if self.bench.run_until(lambda: bool(self.since(mark, GeneralReport)), _ASK_EVERY_S):
                self.run(_LAST_ANSWERS_S)  # to what was asked while it booted
                return True
        self.require_line()
        return False

    def stop(self) -> None:
        """Command both pairs of motors to stop."""
        v2 = self.profile.server.schema is Schema.V2
        self.send(MotorThrottles(a=0.0, b=0.0) if v2 else MotorSpeeds(a=0, b=0))

    def ask_again(self) -> None:
        """Ask for the general report."""
        self.send(RequestTelemetry())

    def stand_still(self) -> None:
        """End an unfinished frame, and stop the motors."""
        self.write(_FLUSH * longest_frame(self.profile.server.frames))
        self.stop()

    def settle(self) -> None:
        """End an unfinished frame, stop the motors, switch the LED off, take the usual gains, discard what comes."""
        for _ in range(2):
            self.write(_FLUSH * longest_frame(self.profile.server.frames))
            self.run(self.line_s(longest_frame(self.profile.server.frames)) + 0.05)
        self.stop()
        self.run(0.05)
        self.send(LedOff())
        if self.profile.server.schema is Schema.V2 and not self.profile.server.pid_reads_late:
            self.run(0.05)
            self.send(_GAINS)
        self.run(0.1)
        self.forget()
