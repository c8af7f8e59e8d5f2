"""What both ends of a P2OS line are at, as somebody sees it who listens: which SYNC was answered, where sessions are.

The same number means SYNC0, SYNC1 and SYNC2 before a session, and PULSE, OPEN and CLOSE in it. A session begins with
its first SIP and ends with CLOSE, with the last SIP before a pause, or where the line was cut. A recording that begins
with SIPs begins in a session.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum

from hilbench.clock import NS_PER_S
from hilbench.recordings.listening import HOST, TARGET, Heard, Stretch
from hilbench.suites._recorded import start_ns
from protocols.p2os import (
    Command,
    ControllerReset,
    Identification,
    RemoteProtocolError,
    ServerPacket,
    Sip,
    SyncEcho,
    decode_command,
    decode_packet,
)

__all__ = ["OPENED", "Means", "Session", "Step", "sessions_of", "steps_of"]

LOST_S = 0.5
"""A pause between two SIPs behind which a session is taken for ended (choice: five cycles)."""


class Means(Enum):
    """What something on the line means, there and then."""

    SYNC0 = "SYNC0"
    SYNC1 = "SYNC1"
    SYNC2 = "SYNC2"
    OPEN = "OPEN"
    CLOSE = "CLOSE"
    PULSE = "PULSE"
    COMMAND = "command"
    PACKET = "packet"
    NOISE = "noise"


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """Something on the line.

    Attributes:
        heard: what it is.
        means: what it means.
        answered: how many SYNCs in a row have been answered before it, 0 to 3; 4 in a session.
        sessions: how many sessions have begun before it.
        command: the command, if it is one.
        packet: the packet, if it is one that can be read.
    """

    heard: Heard
    means: Means
    answered: int
    sessions: int
    command: Command | None = None
    packet: ServerPacket | None = None

    @property
    def start_ns(self) -> int:
        """When its first byte was there, at the usual rate."""
        return start_ns(self.heard)


OPENED = 4
_BEFORE = {0: Means.SYNC0, 1: Means.SYNC1, 2: Means.SYNC2}
_WITHIN = {0: Means.PULSE, 1: Means.OPEN, 2: Means.CLOSE}
_IDENTIFIED = 3


@dataclass(slots=True)
class _State:
    answered: int = 0
    asked: int = 0
    sessions: int = 0
    sip_ns: int = 0

    def meaning(self, command: Command, ns: int) -> Means:
        number = command.number
        if self.answered == OPENED and number == 0 and ns - self.sip_ns > LOST_S * NS_PER_S:
            self.answered = 0
        if self.answered == OPENED:
            return _WITHIN.get(number, Means.COMMAND)
        if number == 1 and (_IDENTIFIED in {self.answered, self.asked} or command.argument is not None):
            return Means.OPEN
        return _BEFORE.get(number, Means.COMMAND)

    def after_command(self, means: Means) -> None:
        if means is Means.CLOSE or means is Means.SYNC0:
            self.answered = 0
        self.asked = {Means.SYNC0: 1, Means.SYNC1: 2, Means.SYNC2: 3}.get(means, 0)

    def after_packet(self, packet: ServerPacket | None, ns: int) -> None:
        if isinstance(packet, Sip):
            # The last SIPs of a session may still be on their way when it has been closed.
            if self.answered == OPENED or self.answered == _IDENTIFIED or not self.sessions:
                self.sessions += self.answered != OPENED
                self.answered = OPENED
            self.sip_ns = ns
        elif isinstance(packet, SyncEcho) and self.asked == packet.number + 1:
            self.answered = self.asked
        elif isinstance(packet, Identification) and self.asked == _IDENTIFIED:
            self.answered = _IDENTIFIED
        elif isinstance(packet, ControllerReset):
            self.answered = 0


def steps_of(stretch: Stretch) -> Iterator[Step]:
    """Yield what passed the line, with what it means."""
    state = _first_state(stretch)
    for heard in stretch.heard:
        command = packet = None
        means = Means.NOISE
        answered, sessions = state.answered, state.sessions
        if heard.sound and heard.by == HOST:
            command = _command(heard)
            means = Means.NOISE if command is None else state.meaning(command, heard.ns)
            answered = state.answered
            state.after_command(means)
        elif heard.sound and heard.by == TARGET:
            packet = _packet(heard)
            means = Means.PACKET
            state.after_packet(packet, heard.ns)
        yield Step(heard=heard, means=means, answered=answered, sessions=sessions, command=command, packet=packet)


def _first_state(stretch: Stretch) -> _State:
    """Return how it was at first: in a session, if SIPs come at once and nobody is seen to open it."""
    until_ns = stretch.begin_ns + round(LOST_S * NS_PER_S)
    packets = () if stretch.from_start else (_packet(one) for one in stretch.by(TARGET) if one.ns <= until_ns)
    first = next((one for one in packets if isinstance(one, Sip | SyncEcho | Identification)), None)
    if isinstance(first, Sip):
        return _State(answered=OPENED, sessions=1, sip_ns=stretch.begin_ns)
    return _State()


def _command(heard: Heard) -> Command | None:
    try:
        return decode_command(heard.item.raw[3:-2])
    except RemoteProtocolError:
        return None


def _packet(heard: Heard) -> ServerPacket | None:
    try:
        return decode_packet(heard.item.raw[3:-2], connected=False) if heard.sound else None
    except RemoteProtocolError:
        return None


@dataclass(slots=True, kw_only=True)
class Session:
    """From a first SIP to the end.

    Attributes:
        stretch: where it is.
        steps: everything from its first SIP on, CLOSE included.
    """

    stretch: Stretch
    steps: list[Step] = field(default_factory=list)

    @property
    def seen_opened(self) -> bool:
        """Whether all of it was heard; else something may have been set in it before."""
        return self.stretch.from_start or self.steps[0].answered != OPENED

    def sips(self) -> list[tuple[Step, Sip]]:
        """Return its SIPs."""
        return [(step, step.packet) for step in self.steps if isinstance(step.packet, Sip)]


def sessions_of(stretch: Stretch) -> Iterator[Session]:
    """Yield the sessions of a stretch."""
    session: Session | None = None
    last_ns = 0
    for step in steps_of(stretch):
        is_sip = isinstance(step.packet, Sip)
        if session is not None and (_lost(step, last_ns) or step.means in {Means.SYNC0, Means.SYNC1, Means.SYNC2}):
            yield session
            session = None
        if is_sip and session is None and (step.answered or not step.sessions):
            session = Session(stretch=stretch)
        last_ns = step.heard.ns if is_sip else last_ns
        if session is None:
            continue
        session.steps.append(step)
        if step.means is Means.CLOSE or isinstance(step.packet, ControllerReset):
            yield session
            session = None
    if session is not None:
        yield session


def _lost(step: Step, last_ns: int) -> bool:
    return isinstance(step.packet, Sip) and step.heard.ns - last_ns > LOST_S * NS_PER_S
