"""One end of a line in the hands of a check, in any protocol: writes what a case wants, keeps what comes back.

It is deliberately not a client: it starts nothing by itself, sends wrong things when told to, and has no opinion about
what it receives. Judging is the business of the case.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from hilbench.bench import Bench
from hilbench.bench.line_end import LineEnd
from hilbench.bench.line_evidence import Passed, Written, in_order, in_words, silence, words_of
from hilbench.bench.timed_reader import TimedReader
from hilbench.clock import NS_PER_S
from hilbench.errors import AwayError, UnavailableError
from hilbench.judging.judge import at_most
from hilbench.judging.verdicts import Inconclusive, Untimely, Violation
from hilbench.links import Port
from protocols.common.checksum import Checksum
from protocols.common.decoding import Decoder
from protocols.common.items import Item

__all__ = ["QUIET_S", "LinePeer", "Received", "Sound", "Unsound"]

MessageT = TypeVar("MessageT")
KindT = TypeVar("KindT")

QUIET_S = 0.25
"""A line with nothing on it for this long is quiet. A choice: two and a half times the usual 100 ms between reports."""

_EVIDENCE_PACKETS, _EVIDENCE_DROPS = 6, 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Sound(Generic[MessageT]):
    """A sound frame: the bytes of it, and what it says; None if that cannot be read."""

    raw: bytes
    packet: MessageT | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Unsound:
    """Bytes that are no frame, and why, as the protocol names it."""

    reason: str
    data: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class Received(Generic[MessageT]):
    """A packet as it came off the line.

    Attributes:
        start_ns: bench time at which its first byte was complete.
        at_ns: bench time at which its last byte was complete.
        raw: the whole frame.
        packet: what it says; None if that cannot be read.
    """

    start_ns: int
    at_ns: int
    raw: bytes
    packet: MessageT | None


class LinePeer(LineEnd, Generic[MessageT]):
    """One end of a line in the hands of a check.

    Args:
        bench: whose time passes while the peer waits.
        port: the line.

    Attributes:
        REPLY_WITHIN_S: how soon an answer is due, in seconds.
        line_expected: whether a line that is down means that the target is gone; a case that hangs up clears it.
    """

    REPLY_WITHIN_S = 0.2

    def __init__(self, bench: Bench, port: Port) -> None:
        self.bench = bench
        self.received: list[Received[MessageT]] = []
        self.dropped: list[Unsound] = []
        self._dropped_ns: list[int] = []
        self._written = Written(lambda: self._decoder(sent=True))
        # What reads frames may have clocks of its own, which do not go back to when bytes came that were read late.
        self._timed: TimedReader[Sound[MessageT] | Unsound] = TimedReader(
            lambda data, at_ns: self._read(data, max(at_ns, self.bench.now_ns))
        )
        self.line_expected = True
        self.attach(port)

    # --- what a protocol brings along

    @abstractmethod
    def _begin_reading(self) -> None:
        """Forget an unfinished frame: what comes now is the beginning of something."""

    @abstractmethod
    def _read(self, data: bytes, at_ns: int) -> Iterable[Sound[MessageT] | Unsound]:
        """Take bytes; return what they complete."""

    @abstractmethod
    def settle(self) -> None:
        """Bring a real target back to where a case may begin, and discard what was received."""

    def checksum(self) -> Checksum | None:
        """Return how frames are checked, if that is known."""
        return None

    def _decoder(self, sent: bool) -> Decoder | None:
        """Return who reads frames for evidence, as this end has sent or heard them; None if nobody does."""
        del sent
        return None

    # --- what was refused

    def refused(self, since: int = 0) -> str:
        """Say what came that was no frame, or is none yet, for the end of a sentence; "" if nothing did.

        Args:
            since: how many had been refused before.
        """
        drops, begun = self.dropped[since:], self._timed.begun
        if not drops:
            return f"; {begun.hex(' ').upper()} came, which is no whole frame" if begun else ""
        count = f"{len(drops)} time{'s' * (len(drops) != 1)}"
        return f"; {count} what came was refused, first for {drops[0].reason}{self._reading_of(drops[0])}"

    def _reading_of(self, drop: Unsound) -> str:
        rule = self.checksum()
        mistake = rule.mistake(drop.data) if rule is not None else ""
        return f": {mistake}" if mistake else ""

    # --- sending

    def write(self, data: bytes) -> None:
        """Put raw bytes on the line, as they are."""
        self.bench.record("tx", "checker", data=data)
        self._written.add(data, self.bench.now_ns)
        self.port.write(data)

    def run(self, duration_s: float) -> None:
        """Let bench time pass, in seconds."""
        self.bench.run_for(duration_s)
        self.require_line()

    # --- looking back

    @property
    def bytes_received(self) -> int:
        """How many bytes were received, in all or since `forget`."""
        return self._timed.bytes_received

    def since(self, mark: int, kind: type[KindT]) -> list[tuple[Received[MessageT], KindT]]:
        """Return the packets of a kind received since ``mark``, each with how it was received."""
        return [(got, got.packet) for got in self.received[mark:] if isinstance(got.packet, kind)]

    def evidence(self, mark: int | None = None) -> Sequence[str]:
        """Return what passed last as lines for a report; see `passed`."""
        lines = [in_words(at_ns, words) for at_ns, words in self.passed(mark or 0)]
        return [*lines, *self.silence(mark or 0)]

    def passed(self, mark: int = 0) -> Sequence[Passed]:
        """Return what passed last, in the order of time.

        Args:
            mark: packets received before it are left out.
        """
        received = [(got.at_ns, f"<  {self.words_of(got)}") for got in self.received[mark:][-_EVIDENCE_PACKETS:]]
        dropped = [*zip(self._dropped_ns, map(self._refused, self.dropped), strict=True)][-_EVIDENCE_DROPS:]
        return in_order(received, dropped, self._written.passed())

    def refused_since(self, since_ns: int) -> Sequence[Passed]:
        """Return what came since a moment and was no frame."""
        refused = zip(self._dropped_ns, map(self._refused, self.dropped), strict=True)
        return [one for one in refused if one[0] >= since_ns]

    def silence(self, mark: int = 0) -> Sequence[str]:
        """Return a line that says what did not come, if there is anything to be said."""
        frames = bool(self.received[mark:] or self.dropped)
        last_ns = self.received[-1].at_ns if self.received else None
        return silence(self.bench.now_ns, self._timed, frames=frames, last_ns=last_ns)

    def kind_of(self, got: Received[MessageT]) -> object:
        """Return what is the same for packets of one kind."""
        return got.packet.name if isinstance(got.packet, Item) else type(got.packet)

    def words_of(self, got: Received[MessageT]) -> str:
        """Return a packet in words."""
        return words_of(got.raw, self._decoder(sent=False))

    def _refused(self, drop: Unsound) -> str:
        return f"<  dropped ({drop.reason})  {drop.data[:32].hex(' ').upper()}{self._reading_of(drop)}"

    def uncertainty_s(self, since_ns: int) -> float:
        """Return how far off times on this bench may be, over what happened since ``since_ns``; see `Bench`."""
        return self.bench.uncertainty_s(since_ns)

    # --- waiting

    def expect(
        self,
        kind: type[KindT],
        within_s: float | None = None,
        *,
        where: Callable[[KindT], bool] | None = None,
        what: str = "",
        mark: int | None = None,
    ) -> KindT:
        """Wait for a packet of a kind, and require it to be in time.

        Args:
            kind: the class of packet.
            within_s: how soon, in seconds of bench time from now, its last byte is due; as soon as an answer if None.
            where: what else must hold for it.
            what: what to call it in a report.
            mark: from where on to look; by default only what comes from now on.

        Raises:
            TypeError: `kind` is no class.
            Untimely: none came.
            Violation: it came too late.
            Inconclusive: it came so close to the limit that the bench cannot tell.
        """
        if not isinstance(kind, type):
            raise TypeError(f"{kind!r} is no class of messages")
        within_s = self.REPLY_WITHIN_S if within_s is None else within_s
        name = what or kind.__name__
        start_ns = self.bench.now_ns
        position = first = self.mark() if mark is None else mark
        refused = len(self.dropped)
        found: list[tuple[int, KindT]] = []

        def arrived() -> bool:
            nonlocal position
            while position < len(self.received) and not found:
                got = self.received[position]
                position += 1
                if isinstance(got.packet, kind) and (where is None or where(got.packet)):
                    found.append((got.at_ns, got.packet))
            return bool(found)

        # Waiting a little beyond the limit tells late from never.
        spare_s = within_s * 0.5 + 0.05
        if not self.bench.run_until(arrived, within_s + spare_s):
            self.require_line()
            text = f"no {name} within {within_s:g} s{self.refused(refused)}"
            raise Untimely(text, self.evidence(first), spare_s=spare_s)
        at_ns, packet = found[0]
        elapsed_s, doubt_s = self.bench.span(start_ns, at_ns)
        at_most(max(0.0, elapsed_s), within_s, unit="s", what=f"{name} came after", uncertainty=doubt_s)
        return packet

    def require_punctual(self, since_ns: int, within_s: float, otherwise: str) -> None:
        """Require that the benches were not so late since a time that what comes next shows nothing.

        Args:
            since_ns: bench time.
            within_s: how late they may have been, in seconds.
            otherwise: what may have come of it, for people.

        Raises:
            Inconclusive: they were later.
        """
        late_s = self.bench.lateness(since_ns).whole_ns / NS_PER_S
        if late_s > within_s:
            raise Inconclusive(f"the bench was up to {late_s * 1000:.1f} ms late: {otherwise}")

    def expect_silence(self, for_s: float, *, why: str = "", settled: bool = False) -> None:
        """Require that nothing at all comes for ``for_s`` seconds.

        Args:
            for_s: in seconds of bench time.
            why: why nothing is to come.
            settled: all that was asked before has been answered, so that nothing may still be on its way.

        Raises:
            Untimely: a byte came; where all is settled a Violation, however late it was read.
        """
        mark, count, start_ns = self.mark(), self.bytes_received, self.bench.now_ns
        self.run(for_s)
        if self.bytes_received != count:
            after_s = (self._timed.last_byte_ns - start_ns) / NS_PER_S
            text = (
                f"{self.bytes_received - count} bytes came (the last after {after_s:.3f} s) where silence is required"
            )
            text += f": {why}" if why else ""
            if settled:
                raise Violation(text, self.evidence(mark))
            raise Untimely(text, self.evidence(mark), spare_s=after_s)

    def wait_quiet(self, for_s: float = QUIET_S, within_s: float = 2.0) -> bool:
        """Let time pass until nothing has come for ``for_s`` seconds; say whether that was so within ``within_s``."""
        end_ns = self.bench.now_ns + round(within_s * NS_PER_S)
        while self.bench.now_ns < end_ns:
            count = self.bytes_received
            self.run(for_s)
            if self.bytes_received == count:
                return True
        return False

    def forget(self) -> None:
        """Discard everything received so far."""
        self._begin_reading()
        self.received.clear()
        self.dropped.clear()
        self._dropped_ns.clear()
        self._written.clear()
        self._timed.bytes_received = 0
        self._timed.begun = b""

    # --- the line

    def attach(self, port: Port) -> None:
        """Use another port from now on; one that has gone meanwhile is forgiven."""
        self.port = port = self.bench.near_end(port)
        self.line_expected = True
        self._went_away = False
        self._begin_reading()
        self._timed.begun = b""
        port.on_receive = self._take
        port.on_line = self._line_changed

    def require_line(self) -> None:
        """Raise UnavailableError if the far end has gone away by itself, whether it is back by now or not.

        AwayError where it may come back.
        """
        if self.line_expected and (self._went_away or not self.port.line_is_up):
            kind = AwayError if self.port.comes_back else UnavailableError
            raise kind("the target closed the line", where=self.port.name)

    def _take(self, data: bytes, at_ns: int) -> None:
        for item in self._timed.receive(data, at_ns):
            self._keep(item, at_ns)

    def _keep(self, item: Sound[MessageT] | Unsound, at_ns: int) -> None:
        if isinstance(item, Unsound):
            self.dropped.append(item)
            self._dropped_ns.append(at_ns)
            self.bench.record("dropped", "checker", reason=item.reason, data=item.data)
            return
        self.bench.record("rx", "checker", data=item.raw, packet=type(item.packet).__name__)
        start_ns = self._timed.start_ns(item.raw)
        self.received.append(Received(start_ns=start_ns, at_ns=at_ns, raw=item.raw, packet=item.packet))

    def _line_changed(self, up: bool, _at_ns: int) -> None:
        self.bench.record("line", "checker", up=up)
        self._went_away |= self.line_expected and not up
