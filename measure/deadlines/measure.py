"""The measurement: a board between a driving stack and a simulator, one of which falls silent at a moment by chance.

Both ends are the checker's. Statuses come 20 times a second and commands 30 times, each at a phase by chance, and each
loss at another; so no time that is measured depends on how the bench's clock and the board's stand to each other.

Two times are taken of each loss. *The deadlines themselves*: from the first frame that the board sends because of the
loss, or with nothing heard since, to the first frame of the new mode; that is a whole number of the documented waits.
*What a user sees*: from the last byte of the last command or status to that frame. It is longer by what the board still
waited for when the silence began.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass, field

from hilbench.bench import Bench
from hilbench.bench.feed import Feed
from hilbench.bench.line_peer import Received
from hilbench.systems.vehicle.driving_stack import COMMAND_HZ
from hilbench.systems.vehicle.simulator_peer import STATUS_HZ, SimulatorPeer
from hilbench.systems.vehicle.stack_peer import StackPeer
from protocols.autoware import AckermannControlCommand, ControlMode, Time, encode_frame, encode_message
from protocols.carla import CommandFrame, Mode, encode_status
from protocols.carla.states import DEADLINES

__all__ = ["BYTE_S", "EVENTS", "Event", "Rig", "Sample", "measure"]

BAUD = 921_600
BYTE_S = 10 / BAUD
"""Both lines work at 921600 baud, 8N1: a byte's time, and how exactly a frame's begin is known."""

NS = 1_000_000_000
COMMANDS = DEADLINES["command_deadline_s"]
STATUSES = DEADLINES["status_deadline_s"]
PAUSE = DEADLINES["manual_pause_s"]
STATUS_PERIOD_S = 1 / STATUS_HZ
SETTLE_S = 0.2
PHASE_S = 0.3
"""Commands, statuses and the board's turns in MANUAL together repeat after this long."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """What is measured.

    Attributes:
        name: what is lost, or comes back.
        deadline_s: the documented time from the first frame in question to the new mode; None if there is none.
        counted: how it comes about.
        seen_least_s: what a user sees at least, as it follows from the documented times,
        seen_most_s: and at most.
        seen: how that comes about.
    """

    name: str
    deadline_s: float | None
    counted: str
    seen_least_s: float
    seen_most_s: float
    seen: str


_LOSS_S = COMMANDS.value_s * COMMANDS.misses
_SILENCE_S = STATUSES.value_s * STATUSES.misses
_MANUAL_S = (STATUSES.value_s + PAUSE.value_s) * STATUSES.misses

EVENTS = {
    "commands": Event(
        name="Commands lost in AUTOWARE, to MANUAL",
        deadline_s=COMMANDS.value_s * (COMMANDS.misses - 1),
        counted="from the first missed command to the tenth, 9 × 110 ms",
        seen_least_s=_LOSS_S + STATUS_PERIOD_S,
        seen_most_s=_LOSS_S + 2 * STATUS_PERIOD_S,
        seen="10 × 110 ms, and before that: the last command waits up to 50 ms for a status, as the frame "
        "before it is not answered yet, and its own frame 50 ms for the next one",
    ),
    "status": Event(
        name="Statuses lost in AUTOWARE, to EMERGENCY",
        deadline_s=_SILENCE_S,
        counted="from the first frame that no status answers, 10 × 100 ms",
        seen_least_s=_SILENCE_S,
        seen_most_s=_SILENCE_S,
        seen="10 × 100 ms: a command is always waiting, so that frame leaves with the last status",
    ),
    "return": Event(
        name="A status in EMERGENCY, to MANUAL",
        deadline_s=None,
        counted="",
        seen_least_s=0.0,
        seen_most_s=0.0,
        seen="at once",
    ),
    "manual": Event(
        name="Statuses lost in MANUAL, to EMERGENCY",
        deadline_s=_MANUAL_S,
        counted="from the first frame that no status answers, 10 × (100 + 60) ms",
        seen_least_s=_MANUAL_S + PAUSE.value_s,
        seen_most_s=_MANUAL_S + 2 * PAUSE.value_s,
        seen="10 × 160 ms, and before that: the last status waits up to 60 ms for the next frame, and a pause follows. "
        "While both run, frames each 60 ms meet statuses each 50 ms at phases 10 ms apart, whatever was drawn",
    ),
}
"""By the names of what `measure` gives."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """One loss or return.

    Attributes:
        deadline_s: from the first frame in question to the new mode; None where there is no such frame.
        seen_s: from the last byte of what came last (or came back) to the new mode.
    """

    deadline_s: float | None
    seen_s: float


@dataclass(slots=True)
class Rig:
    """A board's two lines in the hands of the measurement.

    Attributes:
        bench: whose time passes.
        simulator: the simulator's end of its line.
        stack: the driving stack's end of its line.
        chance: where phases come from.
        statuses: says them.
        commands: says them.
        last_command_ns: when the last byte of the last command was on the line.
        status_ends_ns: the same of each status since `forget`.
    """

    bench: Bench
    simulator: SimulatorPeer
    stack: StackPeer
    chance: random.Random
    statuses: Feed = field(init=False)
    commands: Feed = field(init=False)
    last_command_ns: int = field(init=False, default=0)
    status_ends_ns: list[int] = field(init=False, default_factory=list)
    _spoken: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        """Makes the feeds."""
        self.statuses = Feed(self.bench, self._say_status, name="simulator")
        self.commands = Feed(self.bench, self._say_command, name="stack")

    def feed_statuses(self) -> None:
        """Statuses come from now on, at a phase by chance."""
        self.statuses.start(STATUS_HZ, first_after_s=self.chance.uniform(0, STATUS_PERIOD_S))

    def feed_commands(self) -> None:
        """Commands come from now on, at a phase by chance."""
        self.commands.start(COMMAND_HZ, first_after_s=self.chance.uniform(0, 1 / COMMAND_HZ))

    def drive(self) -> None:
        """Bring the board into AUTOWARE, and let it drive until a moment by chance."""
        self.feed_commands()
        self.run(SETTLE_S)
        if self.simulator.modes()[-1:] != [Mode.AUTOWARE]:
            self.stack.request(ControlMode.AUTONOMOUS)
            self.run(SETTLE_S)
        self.stay(Mode.AUTOWARE)

    def stay(self, mode: Mode) -> None:
        """Forget what was, and let a board in a mode go on until a moment by chance."""
        self.forget()
        self.run(SETTLE_S + self.chance.uniform(0, PHASE_S))
        if set(self.simulator.modes()) != {mode}:
            raise AssertionError(f"the board is not in {mode.name}, but sent {self.simulator.modes()}")

    def run(self, duration_s: float) -> None:
        """Let time pass."""
        self.bench.run_for(duration_s)

    def wait_for(self, mode: Mode, within_s: float) -> Received[CommandFrame]:
        """Wait for the first frame of a mode; what was there before is forgotten by `forget`."""
        looked_at = 0
        found: Received[CommandFrame] | None = None

        def came() -> bool:
            nonlocal looked_at, found
            received = self.simulator.received
            while looked_at < len(received) and found is None:
                got = received[looked_at]
                looked_at += 1
                if got.packet is not None and got.packet.mode == mode:
                    found = got
            return found is not None

        self.bench.run_until(came, within_s)
        if found is None:
            raise AssertionError(f"no {mode.name} within {within_s} s")
        return found

    def frames(self) -> list[Received[CommandFrame]]:
        """The board's frames since `forget`."""
        return self.simulator.frames()

    def before(self, frame: Received[CommandFrame]) -> list[Received[CommandFrame]]:
        """The board's frames since `forget` and before that one."""
        frames = self.frames()
        return frames[: frames.index(frame)]

    def forget(self) -> None:
        """Forget what came from the board."""
        self.simulator.forget()
        self.stack.forget()
        del self.status_ends_ns[:-1]

    def _say_status(self) -> None:
        status = self.simulator.status
        self.status_ends_ns.append(self.bench.now_ns + round(len(encode_status(status)) * BYTE_S * NS))
        self.simulator.send_status(status)

    def _say_command(self) -> None:
        self._spoken += 1
        frame = encode_frame(encode_message(self._command()))
        self.last_command_ns = self.bench.now_ns + round(len(frame) * BYTE_S * NS)
        self.stack.write(frame)

    def _command(self) -> AckermannControlCommand:
        """Each another one, so that a frame that is sent again is known by its speed."""
        return AckermannControlCommand(stamp=Time(self._spoken % 100, 0), speed=1.0 + self._spoken % 100)


def measure(rig: Rig, count: int) -> dict[str, list[Sample]]:
    """Lose and return, so many times; give the samples by the names of `EVENTS`."""
    samples: dict[str, list[Sample]] = {name: [] for name in EVENTS}
    rig.feed_statuses()
    for _ in range(count):
        for name, sample in _round(rig):
            samples[name].append(sample)
    return samples


def _round(rig: Rig) -> Iterator[tuple[str, Sample]]:
    rig.drive()
    yield "commands", _commands_lost(rig)
    rig.drive()
    yield "status", _status_lost(rig)
    yield "return", _status_returns(rig)
    rig.stay(Mode.MANUAL)
    yield "manual", _status_lost(rig)
    _status_returns(rig)


def _commands_lost(rig: Rig) -> Sample:
    rig.commands.stop()
    manual = rig.wait_for(Mode.MANUAL, 2 * _LOSS_S)
    missed = rig.before(manual)[1 - COMMANDS.misses]
    return Sample(
        deadline_s=(manual.start_ns - missed.start_ns) / NS, seen_s=_seen_s(rig.last_command_ns, manual.start_ns)
    )


def _status_lost(rig: Rig) -> Sample:
    rig.statuses.stop()
    emergency = rig.wait_for(Mode.EMERGENCY, 2 * _MANUAL_S)
    unanswered = rig.before(emergency)[-STATUSES.misses]
    rig.commands.stop()
    return Sample(
        deadline_s=(emergency.start_ns - unanswered.start_ns) / NS,
        seen_s=_seen_s(rig.status_ends_ns[-1], emergency.start_ns),
    )


def _status_returns(rig: Rig) -> Sample:
    rig.run(rig.chance.uniform(0, PHASE_S))
    rig.forget()
    rig.feed_statuses()
    manual = rig.wait_for(Mode.MANUAL, 1.0)
    return Sample(deadline_s=None, seen_s=_seen_s(rig.status_ends_ns[1], manual.start_ns))


def _seen_s(last_byte_ns: int, start_ns: int) -> float:
    """From a last byte to the begin of a frame, whose first byte was complete a byte's time later."""
    return (start_ns - last_byte_ns) / NS - BYTE_S
