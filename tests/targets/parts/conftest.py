"""An adapter on a bench: its pins are wires, its line ends at a bare protocol server or at a virtual Pioneer."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest

from protocols.p2os import (
    Command,
    CommandReceived,
    Connection,
    Identification,
    Role,
    ServerOptions,
    ServerState,
    Sip,
    Transmit,
)
from targets.parts.p2os_adapter import P2osAdapter, P2osAdapterSettings
from targets.parts.testing import PartBench, Wire
from targets.parts.words import bits_of, word_of

MS = 1_000_000


class BareRobot:
    """The server role of the protocol, with a SIP every 100 ms of a session.

    Attributes:
        commands: everything that came in a session, with its time in ns.
        sip: what is sent.
        mute: sends nothing.
    """

    def __init__(self, identification: Identification | None = None) -> None:
        known = identification or Identification(name="bare", subclass="p2dx")
        self.connection = Connection(Role.SERVER, ServerOptions(identification=known))
        self.commands: list[tuple[int, Command]] = []
        self.sip = Sip()
        self.mute = False
        self._sip_ns = 0

    def receive(self, data: bytes, now_ns: int) -> bytes:
        return self._handle(self.connection.receive(data, now_ns), now_ns)

    def advance(self, now_ns: int) -> bytes:
        out = self._handle(self.connection.advance(now_ns), now_ns)
        if self.connection.state is ServerState.OPEN and now_ns >= self._sip_ns:
            self._sip_ns = now_ns + 100 * MS
            out += self.connection.send(self.sip, now_ns)
        return b"" if self.mute else out

    def numbers(self) -> list[int]:
        return [command.number for _, command in self.commands]

    def times_ns(self, number: int) -> list[int]:
        return [ns for ns, command in self.commands if command.number == number]

    def _handle(self, events: list, now_ns: int) -> bytes:
        self.commands += [(now_ns, event.command) for event in events if isinstance(event, CommandReceived)]
        out = b"".join(event.data for event in events if isinstance(event, Transmit))
        return b"" if self.mute else out


class AdapterRig:
    """An adapter, wires at its terminals, and a robot at the end of its line; bytes take up to a millisecond.

    Attributes:
        line: every chunk that the adapter sent, with its time in ns.
    """

    def __init__(self, settings: P2osAdapterSettings, robot) -> None:
        self.bench = PartBench(P2osAdapter, settings)
        self.robot = robot
        self.line: list[tuple[int, bytes]] = []
        self.now_ns = 0

    def run(self, duration_s: float) -> None:
        end_ns = self.now_ns + round(duration_s * 1e9)
        while self.now_ns < end_ns:
            self.now_ns = min(end_ns, self.now_ns + MS)
            self.bench.run_to(self.now_ns)
            for _, data in self.bench.sent:
                self.line.append((self.now_ns, data))
                self._to_adapter(self.robot.receive(data, self.now_ns))
            self.bench.sent.clear()
            self._to_adapter(self.robot.advance(self.now_ns))

    def connect(self) -> None:
        """Raise p2dx_con, and wait until the adapter is in session."""
        self.put("p2dx_con", True)
        self.run(2.5)

    def put(self, terminal: str, level: bool) -> None:
        self.bench.wires[terminal].set(level, self.now_ns)

    def codes(self, left: int, right: int) -> None:
        """Put motor codes on the wires, comm3 is the most significant bit."""
        for motor, code in ((1, left), (2, right)):
            for bit, level in enumerate(bits_of(code & 7, "lsb-first"), start=1):
                self.put(f"m{motor}_comm{bit}", level)

    def wire(self, terminal: str) -> Wire:
        return self.bench.wires[terminal]

    def level(self, terminal: str) -> bool | None:
        return self.wire(terminal).driven_at(self.now_ns)

    def distances(self) -> list[bool | None]:
        return [self.level(f"dd{number}") for number in range(1, 9)]

    def encoders(self, order: str) -> tuple[int, int]:
        left, right = (word_of([bool(self.level(f"e{wheel}_s{bit}")) for bit in (1, 2, 3)], order) for wheel in (1, 2))
        return left, right

    def told(self, kind: type) -> list:
        return self.bench.told(kind)

    def sent_after(self, ns: int) -> bytes:
        return b"".join(data for when_ns, data in self.line if when_ns > ns)

    def _to_adapter(self, data: bytes) -> None:
        if data:
            self.bench.receive(data)


@pytest.fixture
def make_adapter() -> Callable[..., AdapterRig]:
    """Makes rigs: robot (a bare one by default), then settings of the adapter by name."""

    def make(robot=None, **settings) -> AdapterRig:
        return AdapterRig(P2osAdapterSettings(**settings), robot or BareRobot())

    return make


@pytest.fixture
def adapter(make_adapter) -> AdapterRig:
    """The published adapter with a bare robot."""
    return make_adapter()


@pytest.fixture
def bare_robot() -> type[BareRobot]:
    """For tests that make their own."""
    return BareRobot


@pytest.fixture
def pulse() -> Callable[[Wire, int, int], None]:
    """Puts a wire high from one time, in ns, to another."""

    def put(wire: Wire, from_ns: int, to_ns: int) -> None:
        wire.set(True, from_ns)
        wire.set(False, to_ns)

    return put


def frames(data: bytes) -> Sequence[str]:
    """Cuts frames apart, as hex."""
    found = []
    while data:
        size = data[2] + 3
        found.append(data[:size].hex(" ").upper())
        data = data[size:]
    return found


@pytest.fixture
def cut_frames() -> Callable[[bytes], Sequence[str]]:
    return frames
