"""The simulator's side under test, as the cases of all files see it, and what they require of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

import pytest

from hilbench.check import CaseSetup, Inconclusive, Untimely, Violation, case
from hilbench.clock import NS_PER_S
from hilbench.errors import InternalError, UnavailableError
from hilbench.systems.vehicle.car_simulator import CarSimulator, Published
from hilbench.systems.vehicle.cases import CarHostCase
from hilbench.systems.vehicle.reporting_car import ReportingCar
from protocols.carla import BAUD, VECTORS, AckermannCommand, ManualCommand, StatusFrame, decode_command, encode_command
from protocols.carla.clauses import HOST_CLAUSES
from targets.robots.car_host import CarState

__all__ = [
    "ACKERMANN",
    "COMMAND",
    "F1",
    "F2",
    "F3",
    "MANUAL",
    "POLL_S",
    "STOP_WITHIN_S",
    "UNDERSTAND_S",
    "Host",
    "alike",
    "host",
    "on_host",
]

FunctionT = TypeVar("FunctionT", bound=Callable[..., object])

_PROFILES = {clause.id: clause.profiles for clause in HOST_CLAUSES}

F1, F2, F3 = (VECTORS[name].data for name in ("F1", "F2", "F3"))
COMMAND = decode_command(F1)
POLL_S = 0.020
START_WITHIN_S = 10.0
"""How long a program may take to its first byte. A choice: a busy machine starts an interpreter in two."""

UNDERSTAND_S = 0.1
"""Until a frame that is complete is understood, and that is told: five polls. A choice."""

STOP_WITHIN_S = 0.5

TELL_WITHIN_S = 1.0
"""So much later a foreign one may hear what it is to do, and tell what its car is commanded. A choice."""

QUIET_S = 0.1
"""Without a status for so long, a foreign one says none by itself any more: two of its cycles (VS20)."""


def on_host(clause_id: str, *, lasts_s: float) -> Callable[[FunctionT], FunctionT]:
    """Declare the case of a clause, in each of its profiles."""
    setups = {profile: CaseSetup(program=profile) for profile in _PROFILES[clause_id]}
    return case(clause_id, bench_time_s=lasts_s, setups=setups)


class Host:
    """A simulator's side under test.

    Args:
        there: the bench, with it started.
    """

    def __init__(self, there: CarHostCase) -> None:
        self.there = there
        self.board = there.board
        self.bench = there.bench

    @property
    def own(self) -> CarSimulator | ReportingCar:
        """Ours, or a foreign one that tells what its car is commanded.

        Raises:
            InternalError: it is one that does not, and the case has not said that it has to.
        """
        if self.there.client.own is None:
            raise InternalError("the case needs to see the car and has not said so")
        return self.there.client.own

    @property
    def ours(self) -> CarSimulator:
        """Ours.

        Raises:
            InternalError: it is a foreign one, and the case has not said that it needs ours.
        """
        if not isinstance(self.own, CarSimulator):
            raise InternalError("the case needs our own simulator's side and has not said so")
        return self.own

    @property
    def commanded(self) -> list[Published]:
        """What the car was commanded, by frames or by CARLA's ackermann node."""
        return self.own.published

    @property
    def published(self) -> list[Published]:
        """The same without the node."""
        return [one for one in self.commanded if not one.by_node]

    @property
    def commands(self) -> list[AckermannCommand | ManualCommand]:
        """The same without the times."""
        return [one.command for one in self.published]

    def say(self, data: bytes, wait_s: float = UNDERSTAND_S) -> None:
        """Put bytes on the line at the time of a poll, and let time pass."""
        self.board.write(data)
        self.board.run(10 * len(data) / BAUD + wait_s)

    @property
    def foreign(self) -> bool:
        """It hears and tells on a line, which may take its time; ours is seen at once."""
        return not isinstance(self.own, CarSimulator)

    def wait_told(self, there: Callable[[], bool]) -> None:
        """Let a foreign one tell something, at most `TELL_WITHIN_S` late."""
        if self.foreign:
            self.bench.run_until(there, TELL_WITHIN_S)

    def told_late_s(self, said_ns: int) -> float:
        """How late a foreign one tells the first command, in seconds, by when its frame was said."""
        if not self.foreign or not self.published:
            return 0.0
        return max(0.0, (self.published[0].ns - said_ns) / NS_PER_S - POLL_S)

    def require(self, *wanted: AckermannCommand | ManualCommand) -> None:
        """Require what the car was commanded since the start, and nothing else."""
        self.wait_told(lambda: len(self.commands) >= len(wanted))
        if self.foreign and self.published:  # whatever else is made of the same bytes is told as late
            behind_ns = self.published[-1].ns + round(UNDERSTAND_S * NS_PER_S) - self.bench.now_ns
            self.board.run(max(0, behind_ns) / NS_PER_S)
        if not _same(self.commands, wanted):
            shown = [f"{one.ns / NS_PER_S:10.4f} s  {one.command}" for one in self.published[:8]] or ["nothing"]
            raise Violation(f"forwarded: {len(self.commands)} commands, required {len(wanted)}", shown)

    def require_no_more(self, *wanted: AckermannCommand | ManualCommand) -> None:
        """Require what the car was commanded since the start, where what was said last commands nothing."""
        if self.foreign:  # what this one commands is told behind all else
            self.say(LAST)
            wanted = (*wanted, LAST_COMMAND)
        self.require(*wanted)

    def require_nothing(self) -> None:
        """Require that nothing was handed on since the start; one that takes no sound frame either shows nothing."""
        self.require_no_more()
        self.require_heard()

    def require_heard(self) -> None:
        """Say a sound frame; what is not handed on shows nothing where this is not, either.

        Raises:
            Inconclusive: nothing is handed on.
        """
        before = len(self.commands)
        self.say(F1)
        self.wait_told(lambda: len(self.commands) > before)
        if len(self.commands) == before:
            raise Inconclusive("F1, which is valid, is not forwarded either", self.board.evidence())

    def move(self, state: CarState) -> None:
        """Say statuses by hand from now on, of a car that moves so."""
        self.own.report_by_hand()
        self.own.sense(state)
        for _ in range(round(TELL_WITHIN_S / QUIET_S) if self.foreign else 0):
            mark = self.board.mark()
            self.board.run(QUIET_S)
            if not self.board.frames(mark):
                break

    def statuses_from_now(self) -> int:
        """Return a mark in the statuses."""
        return self.board.mark()

    def statuses(self, mark: int, wait_s: float) -> list[StatusFrame]:
        """Let time pass, more of it until a foreign one has heard that it is to report; return what came since."""
        self.wait_told(lambda: bool(self.board.frames(mark)))
        self.board.run(wait_s + (QUIET_S if self.foreign else 0.0))
        return [got.packet for got in self.board.frames(mark) if got.packet is not None]


def _same(
    found: Sequence[AckermannCommand | ManualCommand], wanted: Sequence[AckermannCommand | ManualCommand]
) -> bool:
    return len(found) == len(wanted) and all(map(alike, found, wanted))


def alike(one: AckermannCommand | ManualCommand, other: AckermannCommand | ManualCommand) -> bool:
    """Both say the same, as far as floats of 32 bits tell."""
    if type(one) is not type(other):
        return False
    names = one.__dataclass_fields__
    pairs = ((getattr(one, name), getattr(other, name)) for name in names)
    return all(abs(left - right) <= 1e-6 * max(1.0, abs(right)) for left, right in pairs)


@pytest.fixture
def host(bench: CarHostCase) -> Host:
    """The simulator's side, begun."""
    bench.client.start()
    board = bench.board
    if not isinstance(bench.client.own, CarSimulator):
        heard = board.bench.run_until(lambda: board.bytes_received > 0 or bool(bench.client.ended()), START_WITHIN_S)
        if not heard:
            raise Untimely(f"nothing came within {START_WITHIN_S:g} s of its start", spare_s=START_WITHIN_S / 2)
        if board.bytes_received == 0:
            raise UnavailableError(f"the simulator's side {bench.client.ended()} before it sent anything")
    return Host(bench)


ACKERMANN = AckermannCommand(
    steering_rad=0.6, steering_rate_rad_s=0.12, speed_m_s=5.0, acceleration_m_s2=1.0, jerk_m_s3=0.2
)
MANUAL = ManualCommand(steer=-0.5, throttle=0.75, brake=0.0)

LAST = encode_command(replace(COMMAND, speed=7.0))
LAST_COMMAND = replace(ACKERMANN, speed_m_s=7.0)
"""One that no case says for itself, and what it commands."""
