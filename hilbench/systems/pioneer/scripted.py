"""A robot's controller in the hands of a check: answers a client as a case wants it to, and keeps all it hears.

Left alone it is a plain P2OS server: it answers the handshake in order, sends a SIP every 100 ms from OPEN to CLOSE,
and answers CONFIG (Pioneer 2 Operations Manual, client-server chapter). A case replaces what it needs to::

    server.answer("SYNC0", Pause(0.8), encode_packet(SyncEcho(number=0)))    # a late echo
    server.answer("SYNC1", encode_packet(SyncError()), times=1)              # refused once, then as usual
    server.answer("CONFIG")                                                  # silence
    server.stream = lambda tick: damaged_sip if tick % 2 else good_sip       # what goes out each 100 ms

What a client says is called by its name in its place: the same byte is SYNC1 in the handshake and OPEN at its end.
Like a robot on a serial line, the server does not notice that a client is gone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice

from hilbench.bench import Bench, to_ns
from hilbench.bench.line_end import LineEnd
from hilbench.bench.line_evidence import Written, in_order, in_words, silence, words_of
from hilbench.bench.timed_reader import TimedReader
from hilbench.clock import NS_PER_S, EventClass
from hilbench.judging.judge import at_most
from hilbench.judging.verdicts import Untimely
from hilbench.links import Port
from hilbench.systems.pioneer.scripted_packets import CONFIG, IDENTIFICATION, STANDING
from protocols.common.decoding import NoOptions
from protocols.p2os import (
    COMMANDS,
    Command,
    CommandNumber,
    Dropped,
    Frame,
    FrameReader,
    RemoteProtocolError,
    SyncEcho,
    command_name,
    decode_command,
    encode_packet,
)
from protocols.p2os.decoding import decoder

SIP_CYCLE_S = 0.1
"""Time between two SIPs (Pioneer 2 Operations Manual, server information packets)."""

HANDSHAKE_NAMES = ("SYNC0", "SYNC1", "SYNC2")

_EVIDENCE_LINES = 10
# Frames longer than allowed must be seen to be judged.
_LONGEST_COUNT = 255
# A client at another rate sends garbage that can look like a header; a frame is not waited for longer than this.
_FRAME_TIMEOUT_NS = NS_PER_S // 2


@dataclass(frozen=True, slots=True)
class Pause:
    """A pause within an answer, in seconds."""

    duration_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Heard:
    """A frame of the client's.

    Attributes:
        start_ns: bench time at which its first byte was complete.
        at_ns: bench time at which its last byte was complete.
        raw: the frame from header to checksum.
        command: what it says; None if that cannot be read.
        name: what it is called in its place: "SYNC0" to "SYNC2" in the handshake, "OPEN", "PULSE", "CLOSE", or the
            command's own name.
    """

    start_ns: int
    at_ns: int
    raw: bytes
    command: Command | None
    name: str


@dataclass(slots=True)
class _Answer:
    parts: Sequence[bytes | Pause]
    times_left: int | None


class ScriptedServer(LineEnd):
    """One end of a P2OS line, in the place of a robot.

    Args:
        bench: whose time passes while a case waits.
        port: the server's end of the line.

    Attributes:
        received: the frames heard, oldest first.
        dropped: what was heard and was no frame.
        in_session: whether a session is open.
        sessions_opened: how many sessions the client has opened, by a whole handshake.
        stream: gives the bytes that go out in a SIP's place, for the number of the cycle counted from 0; none for an
            empty string.
        last_sip_ns: bench time at which the latest bytes of the stream were handed to the line; 0 before that.
    """

    def __init__(self, bench: Bench, port: Port) -> None:
        self.bench = bench
        self.port = port = bench.near_end(port)
        self.received: list[Heard] = []
        self.dropped: list[Dropped] = []
        self.in_session = False
        self.sessions_opened = 0
        self.stream: Callable[[int], bytes] = lambda _tick: encode_packet(STANDING)
        self.last_sip_ns = 0
        self._step = 0  # how many SYNCs of the present handshake were understood
        self._answers: dict[str, _Answer] = {}
        self._usual: dict[str, bytes] = {
            "SYNC0": encode_packet(SyncEcho(number=0)),
            "SYNC1": encode_packet(SyncEcho(number=1)),
            "SYNC2": encode_packet(IDENTIFICATION),
            "CONFIG": encode_packet(CONFIG),
        }
        self._written = Written(lambda: decoder(NoOptions(), "target"))
        self._closed = False
        self._stream_number = 0
        self._sips_after_close = 0
        self._reader = TimedReader(FrameReader(max_count=_LONGEST_COUNT, timeout_ns=_FRAME_TIMEOUT_NS).receive)
        port.on_receive = self._take
        port.on_line = self._line_changed

    # --- the script

    def answer(self, name: str, *parts: bytes | Pause, times: int | None = None) -> None:
        """Replace the answer to a command by bytes and pauses, or by silence where there are none.

        Args:
            name: as in `Heard.name`.
            parts: whole frames, pieces of frames, pauses.
            times: how often, before the usual answer is back; None for always.
        """
        if name not in _NAMES:
            raise ValueError(f"no command is called {name!r}")
        self._answers[name] = _Answer(parts, times)

    def silence(self) -> None:
        """Answer nothing at all from now on."""
        for name in self._usual:
            self.answer(name)

    def begin_session(self, *, sips_after_close: int = 0) -> None:
        """Be in session, whatever came before: SIPs begin after one cycle.

        Args:
            sips_after_close: how many SIPs still come once the client has closed, as of a robot whose cycle had begun.
        """
        self.in_session = True
        self._step = 0
        self._sips_after_close = sips_after_close
        self._stream_number += 1
        self._book_sip(self._stream_number, 0)

    def end_session(self) -> None:
        """Leave the session without a word, as a controller does that is switched off and on."""
        self.in_session = False
        self._stream_number += 1

    def write(self, *parts: bytes | Pause) -> None:
        """Put bytes on the line: at once, or after the pauses before them."""
        delay_ns = 0
        for part in parts:
            if isinstance(part, Pause):
                delay_ns += to_ns(part.duration_s)
            elif not delay_ns:
                self._put(part)
            else:
                self.bench.scheduler.after(delay_ns, partial(self._put, part), source="server")

    def close(self) -> None:
        """Leave the port to another: nothing more is sent, and nothing more is heard."""
        self._closed = True
        self.end_session()

    # --- looking back

    @property
    def bytes_received(self) -> int:
        """How many bytes were heard in all."""
        return self._reader.bytes_received

    def heard(self, *names: str, mark: int = 0) -> list[Heard]:
        """Return the frames of these names (all frames for none) heard since ``mark``."""
        return [heard for heard in self.received[mark:] if not names or heard.name in names]

    def kind_of(self, got: Heard) -> object:
        """Return the name of a command."""
        return got.name

    def words_of(self, got: Heard) -> str:
        """Return a command in words."""
        return _in_words(got)

    def evidence(self) -> list[str]:
        """Return the latest frames and what was dropped, as lines for a report."""
        heard = [(got.at_ns, f"<  {self.words_of(got)}") for got in self.received[-_EVIDENCE_LINES:]]
        passed = in_order(heard, self._written.passed())
        lines = [in_words(*one) for one in passed]
        lines += [f"dropped ({drop.reason.name})  {drop.data[:32].hex(' ').upper()}" for drop in self.dropped[-2:]]
        return [*lines, *silence(self.bench.now_ns, self._reader, frames=bool(heard or self.dropped))]

    def uncertainty_s(self, since_ns: int) -> float:
        """Return how far off times on this bench may be, over what happened since ``since_ns``; see `Bench`."""
        return self.bench.uncertainty_s(since_ns)

    # --- waiting

    def run(self, duration_s: float) -> None:
        """Let bench time pass, in seconds."""
        self.bench.run_for(duration_s)

    def wait(self, condition: Callable[[], bool], within_s: float) -> bool:
        """Let bench time pass until the condition holds; say whether it does within ``within_s`` seconds."""
        return self.bench.run_until(condition, within_s)

    def expect_command(
        self,
        name: str,
        within_s: float,
        *,
        where: Callable[[Heard], bool] | None = None,
        mark: int | None = None,
        what: str = "",
    ) -> Heard:
        """Wait for a command, and require it to be in time.

        Args:
            name: as in `Heard.name`.
            within_s: how soon, in seconds of bench time from now, its last byte is due.
            where: what else must hold for it.
            mark: from where on to look; by default only what comes from now on.
            what: what to call it in a report.

        Raises:
            Untimely: it did not come.
            Violation: it came too late.
            Inconclusive: it came so close to the limit that the bench cannot tell.
        """
        what = what or name
        start_ns = self.bench.now_ns
        first = self.mark() if mark is None else mark
        found: list[Heard] = []
        position = first

        def arrived() -> bool:
            nonlocal position
            for heard in islice(self.received, position, None):
                position += 1
                if heard.name == name and (where is None or where(heard)):
                    found.append(heard)
                    return True
            return False

        # Waiting a little beyond the limit tells late from never.
        spare_s = within_s * 0.2 + 0.05
        if not self.wait(arrived, within_s + spare_s):
            raise Untimely(f"no {what} within {within_s:g} s", spare_s=spare_s)
        elapsed_s = max(0, found[0].at_ns - start_ns) / NS_PER_S
        at_most(elapsed_s, within_s, unit="s", what=f"{what} came after", uncertainty=self.uncertainty_s(start_ns))
        return found[0]

    def expect_session(self, within_s: float) -> Heard:
        """Wait until the client has opened a session by a whole handshake, and return its OPEN.

        Raises:
            Untimely: it did not within ``within_s`` seconds from now, at least twice as long as one needs.
        """
        opened = self.sessions_opened
        if not self.wait(lambda: self.sessions_opened > opened, within_s):
            raise Untimely(f"no session was opened within {within_s:g} s", spare_s=within_s / 2)
        return self.heard("OPEN")[-1]

    def expect_silence(self, for_s: float, *, why: str = "") -> None:
        """Require that the client sends nothing for ``for_s`` seconds.

        Raises:
            Untimely: it did.
        """
        count, mark, start_ns = self.bytes_received, self.mark(), self.bench.now_ns
        self.run(for_s)
        if self.bytes_received != count:
            names = ", ".join(heard.name for heard in self.received[mark:]) or "bytes that are no frame"
            after_s = (self._reader.last_byte_ns - start_ns) / NS_PER_S
            raise Untimely(f"{names} came where silence is required" + (f": {why}" if why else ""), spare_s=after_s)

    def wait_quiet(self, for_s: float, within_s: float) -> bool:
        """Let time pass until nothing was heard for ``for_s`` seconds; say whether that began within ``within_s``."""
        end_ns = self.bench.now_ns + to_ns(within_s)
        while self.bench.now_ns <= end_ns:
            count = self.bytes_received
            self.run(for_s)
            if self.bytes_received == count:
                return True
        return False

    # --- what it does

    def _take(self, data: bytes, at_ns: int) -> None:
        if self._closed:
            return
        for item in self._reader.receive(data, at_ns):
            self._hear(item, at_ns)

    def _hear(self, item: Frame | Dropped, at_ns: int) -> None:
        if isinstance(item, Dropped):
            self.dropped.append(item)
            self.bench.record("dropped", "server", reason=item.reason.name, data=item.data)
            return
        try:
            command = decode_command(item.body)
        except RemoteProtocolError:
            command = None
        name = self._name_of(command) if command is not None else f"#{item.body[0]} that cannot be read"
        start_ns = self._reader.start_ns(item.raw)
        self.bench.record("rx", "server", data=item.raw, name=name)
        self.received.append(Heard(start_ns=start_ns, at_ns=at_ns, raw=item.raw, command=command, name=name))
        self._obey(name)

    def _name_of(self, command: Command) -> str:
        """Return what a command is in its place."""
        number = command.number
        if self.in_session or number > CommandNumber.CLOSE or command.argument is not None:
            return command_name(number)
        identified = self._step == len(HANDSHAKE_NAMES)
        return "OPEN" if identified and number == CommandNumber.OPEN else HANDSHAKE_NAMES[number]

    def _obey(self, name: str) -> None:
        if self.in_session:
            if name == "CLOSE":
                self._close()
            else:
                self._reply(name)
        elif name == "OPEN" and self._step == len(HANDSHAKE_NAMES):
            self.sessions_opened += 1
            self.begin_session()
        elif name in HANDSHAKE_NAMES and HANDSHAKE_NAMES.index(name) <= self._step:
            self._step = HANDSHAKE_NAMES.index(name) + 1
            self._reply(name)

    def _close(self) -> None:
        sips = self._sips_after_close
        self.end_session()
        for cycle in range(sips):
            self.write(Pause((cycle + 1) * SIP_CYCLE_S), self.stream(cycle))

    def _reply(self, name: str) -> None:
        scripted = self._answers.get(name)
        if scripted is None:
            if name in self._usual:
                self.write(self._usual[name])
            return
        self.write(*scripted.parts)
        if scripted.times_left is not None:
            scripted.times_left -= 1
            if not scripted.times_left:
                del self._answers[name]

    def _book_sip(self, stream_number: int, tick: int) -> None:
        action = partial(self._send_sip, stream_number, tick)
        self.bench.scheduler.after(to_ns(SIP_CYCLE_S), action, order=EventClass.TIMER, source="server")

    def _send_sip(self, stream_number: int, tick: int) -> None:
        if stream_number != self._stream_number:
            return  # that session is over
        data = self.stream(tick)
        if data:
            self.last_sip_ns = self.bench.now_ns
            self._put(data)
        self._book_sip(stream_number, tick + 1)

    def _put(self, data: bytes) -> None:
        if not self._closed:
            self.bench.record("tx", "server", data=data)
            self._written.add(data, self.bench.now_ns)
            self.port.write(data)

    def _line_changed(self, up: bool, _at_ns: int) -> None:
        self.bench.record("line", "server", up=up)


def _in_words(got: Heard) -> str:
    if got.name in HANDSHAKE_NAMES:
        return f"{got.name}  [{got.raw.hex(' ').upper()}]"
    return words_of(got.raw, decoder(NoOptions(), "host"))


_NAMES = frozenset((*HANDSHAKE_NAMES, *(spec.name for spec in COMMANDS.values())))
