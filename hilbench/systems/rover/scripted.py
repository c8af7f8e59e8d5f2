"""A PKT! rover in the hands of a check: keeps all that a host says, and says what a case wants.

Left alone it answers each REQUEST_TMY with 0x80 and says nothing else. It executes nothing and counts nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from hilbench.bench import Bench
from hilbench.bench.line_end import LineEnd
from hilbench.bench.line_evidence import Written, in_order, in_words, silence, words_of
from hilbench.bench.timed_reader import TimedReader
from hilbench.links import Port
from protocols.pkt import (
    Command,
    Dropped,
    Frame,
    FrameReader,
    FrameTimer,
    Framing,
    FramingOptions,
    GeneralReport,
    Profile,
    RemoteProtocolError,
    Report,
    RequestTelemetry,
    Resync,
    decode_command,
    encode_frame,
    encode_report,
)
from protocols.pkt.decoding import DecodeOptions, decoder

__all__ = ["HeardCommand", "ScriptedRover"]

_EVIDENCE_LINES = 10


@dataclass(frozen=True, slots=True, kw_only=True)
class HeardCommand:
    """A frame of the host's.

    Attributes:
        start_ns: bench time at which its first byte was complete.
        at_ns: bench time at which its last byte was complete.
        raw: the whole frame.
        payload: what it carries.
        command: what that says; None if it cannot be read.
    """

    start_ns: int
    at_ns: int
    raw: bytes
    payload: bytes
    command: Command | None


class ScriptedRover(LineEnd):
    """One end of a PKT! line, in the place of a rover.

    Args:
        bench: whose time passes while a case waits.
        port: the rover's end of the line.
        profile: what it speaks.

    Attributes:
        received: the frames heard, oldest first.
        dropped: what was heard and was no frame.
        answers: whether REQUEST_TMY is answered.
        general: what the answer says.
    """

    def __init__(self, bench: Bench, port: Port, profile: Profile) -> None:
        self.bench = bench
        self.port = port = bench.near_end(port)
        self.profile = profile
        self.received: list[HeardCommand] = []
        self.dropped: list[Dropped] = []
        self.answers = True
        self.general = GeneralReport(status=0 if profile.server.general_status else None)
        frames = profile.server.frames
        tolerant = frames.framing is Framing.TERM
        options = FramingOptions(framing=frames.framing, tolerant_newline=tolerant, resync=Resync.SCAN)
        reader = FrameReader(replace(options, timer=FrameTimer.SINCE_LAST_BYTE))
        self._reader = TimedReader(reader.receive)
        self._written = Written(lambda: decoder(self._options, "target"))
        self._closed = False
        port.on_receive = self._take
        port.on_line = lambda up, _at_ns: bench.record("line", "rover", up=up)

    @property
    def _options(self) -> DecodeOptions:
        return DecodeOptions(framing=self.profile.server.frames.framing, schema=self.profile.server.schema)

    # --- the script

    def frame(self, report: Report) -> bytes:
        """Return the frame of a report, as the rover would send it."""
        return self.frame_around(encode_report(report, self.profile.server.schema))

    def frame_around(self, payload: bytes) -> bytes:
        """Return a sound frame around a payload."""
        return encode_frame(payload, self.profile.server.frames)

    def say(self, report: Report) -> None:
        """Put a report on the line."""
        self.write(self.frame(report))

    def write(self, data: bytes) -> None:
        """Put bytes on the line, as they are."""
        self.bench.record("tx", "rover", data=data)
        self._written.add(data, self.bench.now_ns)
        self.port.write(data)

    def close(self) -> None:
        """Leave the port to another: nothing more is said, and nothing more is heard."""
        self._closed = True

    # --- looking back

    @property
    def bytes_received(self) -> int:
        """How many bytes were heard in all."""
        return self._reader.bytes_received

    def heard(self, *kinds: type[Command], mark: int = 0) -> list[HeardCommand]:
        """Return the frames heard since ``mark``; of some kinds of command, or all for none."""
        return [heard for heard in self.received[mark:] if not kinds or isinstance(heard.command, kinds)]

    def kind_of(self, got: HeardCommand) -> object:
        """Return what is the same for commands of one kind."""
        return type(got.command)

    def words_of(self, got: HeardCommand) -> str:
        """Return a command in words."""
        return words_of(got.raw, decoder(self._options, "host"))

    def evidence(self) -> list[str]:
        """Return the latest frames and what was dropped, as lines for a report."""
        latest = self.received[-_EVIDENCE_LINES:]
        heard = [(got.at_ns, f"<  {self.words_of(got)}") for got in latest]
        passed = in_order(heard, self._written.passed())
        lines = [in_words(*one) for one in passed]
        lines += [f"dropped ({drop.reason.name})  {drop.data[:32].hex(' ').upper()}" for drop in self.dropped[-2:]]
        return [*lines, *silence(self.bench.now_ns, self._reader, frames=bool(heard or self.dropped))]

    def wait(self, condition: Callable[[], bool], within_s: float) -> bool:
        """Let time pass until something holds; say whether it does."""
        return self.bench.run_until(condition, within_s)

    def line_s(self, size: int) -> float:
        """Return how long so many bytes take on the line, in seconds."""
        return 10 * size / self.port.baud if self.port.baud else 0.0

    def _take(self, data: bytes, at_ns: int) -> None:
        if self._closed:
            return
        for found in self._reader.receive(data, at_ns):
            self._keep(found, at_ns)

    def _keep(self, found: Frame | Dropped, at_ns: int) -> None:
        if isinstance(found, Dropped):
            self.dropped.append(found)
            self.bench.record("dropped", "rover", reason=found.reason.name, data=found.data)
            return
        try:
            command = decode_command(found.payload, self.profile.server.schema)
        except RemoteProtocolError:
            command = None
        self.bench.record("rx", "rover", data=found.raw, command=type(command).__name__)
        start_ns = self._reader.start_ns(found.raw)
        heard = HeardCommand(start_ns=start_ns, at_ns=at_ns, raw=found.raw, payload=found.payload, command=command)
        self.received.append(heard)
        if self.answers and isinstance(command, RequestTelemetry):
            self.say(self.general)
