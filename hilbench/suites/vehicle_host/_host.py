"""The simulator's side under test, as the cases of all files see it, and what they require of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import pytest

from hilbench.check import CaseSetup, Inconclusive, Untimely, Violation, case
from hilbench.clock import NS_PER_S
from hilbench.errors import InternalError, UnavailableError
from hilbench.systems.vehicle.car_simulator import CarSimulator, Published
from hilbench.systems.vehicle.cases import CarHostCase
from hilbench.systems.vehicle.reporting_car import ReportingCar
from protocols.carla import BAUD, VECTORS, AckermannCommand, ManualCommand, decode_command
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

    def require(self, *wanted: AckermannCommand | ManualCommand) -> None:
        """Require what the car was commanded since the start, and nothing else."""
        if not _same(self.commands, wanted):
            shown = [f"{one.ns / NS_PER_S:10.4f} s  {one.command}" for one in self.published[:8]] or ["nothing"]
            raise Violation(f"forwarded: {len(self.commands)} commands, required {len(wanted)}", shown)

    def require_nothing(self) -> None:
        """Require that nothing was handed on since the start; one that takes no sound frame either shows nothing."""
        self.require()
        self.require_heard()

    def require_heard(self) -> None:
        """Say a sound frame; what is not handed on shows nothing where this is not, either.

        Raises:
            Inconclusive: nothing is handed on.
        """
        before = len(self.commands)
        self.say(F1)
        if len(self.commands) == before:
            raise Inconclusive("F1, which is valid, is not forwarded either", self.board.evidence())

    def move(self, state: CarState) -> None:
        """Say statuses by hand from now on, of a car that moves so."""
        self.own.report_by_hand()
        self.own.sense(state)

    def statuses_from_now(self) -> int:
        """Return a mark in the statuses."""
        return self.board.mark()


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
