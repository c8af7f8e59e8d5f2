"""Puts a mutant on the virtual bench and runs its suites against it."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import cast

from hilbench.bench import Bench
from hilbench.bench.shared import Shared
from hilbench.benchfile.reader import open_bench
from hilbench.check.results import Report
from hilbench.check.runner import run_suites
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.judging.provider import CaseInfo
from hilbench.links import Port
from hilbench.systems.pioneer.cases import VirtualCase, make_client, no_tap
from hilbench.systems.pioneer.client import P2osClient
from hilbench.systems.pioneer.provider import VirtualProvider
from hilbench.systems.pioneer.robot import PioneerPlan, make_robot, plan_of
from hilbench.terminal.options import CheckOptions
from measure.mutants.each_its_own import Fault
from measure.mutants.mutant import BodyFault, Family, Mutant
from measure.mutants.wire import Tap
from protocols.p2os import ClientOptions, Connection, Event, Role, ServerOptions, Table, client_table, server_table
from protocols.p2os.states import State, Trigger
from targets.robots.pioneer import Chassis, PioneerRobot, RobotSettings, server_options
from worlds.vehicles.pioneer_2dx import Pioneer2dxBody


def run_mutant(mutant: Mutant | None, family: Family, *, select: str = "", suites: tuple[str, ...] = ()) -> Report:
    """Run the suites of a family against a mutant, or against the right device for None; return the report."""
    shared = Shared(bench_file=open_bench("pioneer"), timeout_scale=1.0, journal=Journal())
    provider = MutantProvider(shared, mutant, motion="pioneer-motion" in (suites or family.suites))
    try:
        return run_suites(CheckOptions(suites=suites or family.suites, select=select), provider)
    finally:
        provider.close()


def fault(mutant: Mutant, clause_id: str, *, motion: bool = False) -> Fault:
    """A mutant as something that a clause has to find; `motion` as for `MutantProvider`."""
    shared = Shared(bench_file=open_bench("pioneer"), timeout_scale=1.0, journal=Journal())
    open_case = MutantProvider(shared, mutant, motion=motion).open_case
    return Fault(name=mutant.id, clause_id=clause_id, open_case=open_case)


def edges_taken() -> frozenset[tuple[State, Trigger]]:
    """Run the suites of both roles against the right device; return the edges of the state tables that were taken."""
    connections: list[Connection] = []

    def watched_robot(settings: RobotSettings, body: Pioneer2dxBody, seed: int) -> PioneerRobot:
        robot = make_robot(settings, body, seed)
        connections.append(robot.connection)
        return robot

    def watched_client(bench: Bench, port: Port, options: ClientOptions) -> P2osClient:
        client = make_client(bench, port, options)
        connections.append(client.connection)
        return client

    shared = Shared(bench_file=open_bench("pioneer"), timeout_scale=1.0, journal=Journal())
    plan = replace(plan_of(shared.bench_file), make_robot=watched_robot)
    provider = VirtualProvider(shared, plan=plan, make_client=watched_client)
    run_suites(CheckOptions(suites=("p2os-server", "p2os-client")), provider)
    return frozenset(edge for connection in connections for edge in connection.visits)


class MutantProvider:
    """Gives each case a fresh bench with the mutant on it.

    A case of the server that asks for no scene is about the line and the controller, not about contacts and rays: it
    gets the physics of an endless floor, which takes half the time and gives the right device the same verdicts.

    Args:
        shared: bench file, journal, waiting.
        mutant: what is wrong; None for nothing.
        motion: give every case the full physics.
    """

    def __init__(self, shared: Shared, mutant: Mutant | None, *, motion: bool) -> None:
        plan = _plan(plan_of(shared.bench_file), mutant)
        client = partial(_make_client, mutant=mutant) if mutant is not None else make_client
        tap = partial(_tap, mutant=mutant) if mutant is not None and mutant.wire else no_tap
        self._full = VirtualProvider(shared, plan=plan, make_client=client, tap=tap)
        self._floor = VirtualProvider(shared, plan=replace(plan, physics="plane"), make_client=client, tap=tap)
        self._motion = motion
        self.capabilities = self._full.capabilities
        self.describe = self._full.describe
        self.close = self._full.close

    def prepare(self, cases: Sequence[CaseInfo]) -> None:
        """Say that the full physics is missing, if one of these cases gets it."""
        self._full.prepare([case for case in cases if self._provider_of(case) is self._full])

    @contextlib.contextmanager
    def open_case(self, case: CaseInfo) -> Iterator[VirtualCase]:
        """Open a bench for one case."""
        with self._provider_of(case).open_case(case) as bench:
            yield bench

    def _provider_of(self, case: CaseInfo) -> VirtualProvider:
        return self._full if self._motion or case.scene else self._floor


def _plan(plan: PioneerPlan, mutant: Mutant | None) -> PioneerPlan:
    if mutant is None or mutant.family.of_client:
        return plan
    settings = replace(plan.settings, **mutant.settings)  # type: ignore[arg-type]
    return replace(plan, settings=settings, make_robot=partial(_make_robot, mutant=mutant))


def _make_robot(settings: RobotSettings, body: Pioneer2dxBody, seed: int, *, mutant: Mutant) -> PioneerRobot:
    chassis: Chassis = FaultyBody(body, mutant.body) if mutant.body is not None else body
    if not (mutant.edges or mutant.mute or mutant.server_options):
        return make_robot(settings, chassis, seed)  # type: ignore[arg-type]
    options = replace(server_options(settings), **mutant.server_options)  # type: ignore[arg-type]
    connection = MutedConnection(
        Role.SERVER, options, table=mutant.mutate(server_table(options.wrong_order)), mute=mutant.mute
    )
    return PioneerRobot(settings, chassis, seed=seed, connection=connection)


def _make_client(bench: Bench, port: Port, options: ClientOptions, *, mutant: Mutant) -> P2osClient:
    faulty = replace(options, **mutant.client_options)  # type: ignore[arg-type]
    return P2osClient(bench, port, faulty, table=mutant.mutate(client_table(request_config=faulty.request_config)))


def _tap(scheduler: Scheduler, port: Port, *, mutant: Mutant) -> Port:
    return cast("Port", Tap(scheduler, port, mutant.wire, mutant.longest_in))


class MutedConnection(Connection):
    """A connection some of whose events are lost on their way to the robot.

    Args:
        role, options, table: as for `Connection`.
        mute: class names of the events.
    """

    def __init__(self, role: Role, options: ServerOptions, *, table: Table, mute: frozenset[str]) -> None:
        super().__init__(role, options, table=table)
        self._mute = mute

    def receive(self, data: bytes, now_ns: int) -> list[Event]:
        """As `Connection.receive`, less what is mute."""
        return self._left(super().receive(data, now_ns))

    def advance(self, now_ns: int) -> list[Event]:
        """As `Connection.advance`, less what is mute."""
        return self._left(super().advance(now_ns))

    def line_down(self, now_ns: int) -> list[Event]:
        """As `Connection.line_down`, less what is mute."""
        return self._left(super().line_down(now_ns))

    def _left(self, events: list[Event]) -> list[Event]:
        return [event for event in events if type(event).__name__ not in self._mute]


_SEGMENTS = 5
_FRONT_DISCS = 8


class FaultyBody:
    """A body seen through a fault; see `BodyFault`."""

    def __init__(self, body: Chassis, fault: BodyFault) -> None:
        self._body = body
        self._fault = fault

    def command_wheels(self, left_rad_s: float, right_rad_s: float) -> None:
        """Turn the wheels, not quite as told."""
        speeds = [
            speed * scale for speed, scale in zip((left_rad_s, right_rad_s), self._fault.wheel_scale, strict=True)
        ]
        top = self._fault.top_rad_s
        if top is not None:
            speeds = [max(-top, min(top, speed)) for speed in speeds]
        self._body.command_wheels(*speeds)

    def release_wheels(self) -> None:
        """Let go of the wheels, or not."""
        if not self._fault.never_released:
            self._body.release_wheels()

    def wheel_angles_rad(self) -> tuple[float, float]:
        """The wheels as they turned; divided by their scale, so that the controller does not notice."""
        left, right = self._body.wheel_angles_rad()
        return left / self._fault.wheel_scale[0], right / self._fault.wheel_scale[1]

    def motor_loads(self) -> tuple[float, float]:
        """The loads, or what is taken for them."""
        load = self._fault.motor_load
        return self._body.motor_loads() if load is None else (load, load)

    def bumpers(self) -> tuple[int, int]:
        """The bumpers, or what is taken for them."""
        front, rear = self._body.bumpers()
        if self._fault.bumpers_mirrored:
            front, rear = _mirrored(front), _mirrored(rear)
        return (rear, front) if self._fault.bumpers_swapped else (front, rear)

    def sonar_range_m(self, number: int) -> float | None:
        """The range of a disc, or what is taken for it."""
        fault = self._fault
        if number in fault.sonar_deaf:
            return None
        disc = _FRONT_DISCS - 1 - number if fault.sonar_mirrored and number < _FRONT_DISCS else number
        range_m = self._body.sonar_range_m(disc)
        return None if range_m is None else max(0.0, range_m * fault.sonar_scale + fault.sonar_shift_m)


def _mirrored(mask: int) -> int:
    return sum(1 << (_SEGMENTS - 1 - bit) for bit in range(_SEGMENTS) if mask >> bit & 1)
