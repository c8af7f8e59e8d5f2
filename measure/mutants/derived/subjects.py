"""Who is made wrong: a protocol's side, the suites that have to find it, and the benches that they run on.

A subject is checked in three ways, all in virtual time. *At a port* it stands at the far end of a line as somebody
else's, and the bench can do what a bench with a port can. *By hand* somebody stands beside it there who is asked, as an
operator's hook is. *As a model* each case has a fresh one on a bench that can do everything.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any
from unittest.mock import patch

from hilbench.bench import Bench
from hilbench.bench.locked_providers import ExecProvider, LockedProvider
from hilbench.bench.operator import Operator
from hilbench.bench.shared import Shared
from hilbench.benchfile.reader import BenchFile, open_bench
from hilbench.clock import NS_PER_MS, Scheduler
from hilbench.errors import UsageError
from hilbench.journal import Journal
from hilbench.judging.provider import BenchProvider
from hilbench.links import Line, MemoryLink, Port
from hilbench.links.memory import MemoryPort
from hilbench.links.serial_target import SerialTarget
from hilbench.plugins.discovery import PLUGINS
from hilbench.plugins.protocol import ProtocolPlugin
from hilbench.protocol_bench.system import system_of
from hilbench.systems.pioneer.client import P2osClient
from hilbench.systems.pioneer.reporting_client import ClientReporter
from hilbench.systems.rover.ground_station import GroundStation
from hilbench.systems.rover.reporting_station import StationReporter
from hilbench.systems.vehicle.car_simulator import CarSimulator
from hilbench.systems.vehicle.reporting_car import CarReporter
from hilbench.terminal.options import TargetChoice
from hilbench.through import Routes
from measure.mutants.beside import BesideRover, BesideVehicle
from measure.mutants.derived.fields import Reading
from measure.mutants.in_bench_time import ForeignRoverInBenchTime, ForeignVehicleInBenchTime
from measure.mutants.wire import Way
from protocols.p2os import ClientOptions
from protocols.pkt import PROFILES
from targets.robots.car_host import CarHostSettings
from targets.robots.rover import RoverRobot, RoverSettings
from targets.robots.vehicle_interface import VehicleInterface, VehicleSettings

__all__ = ["SUBJECTS", "MakeRelay", "Subject", "bench_of", "opened"]

Program = Callable[[Bench, Port], Any]
"""Makes a host that can `connect` and `disconnect`."""
Tell = Callable[[Bench, Any, Port], object]
"""Puts what tells of a host, and hands on what it is told, at the host's end of a line."""
MakeBeside = Callable[[Shared], BenchProvider]
"""Opens benches with a model at a port, and the operator of what they share beside it."""
MakeRelay = Callable[[Scheduler, Port], Port]
"""Puts a relay in front of a checker's end of a line."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Subject:
    """One side of a protocol, put to the test.

    Attributes:
        name: what a command line calls it.
        title: what people call it.
        protocol: what it speaks, by the name of its record.
        bench: name or path of the bench.
        suites: those that have to find the fault; those of the bench if empty.
        select: which of their cases.
        line: which of the checker's lines it is, by a part of the port's name; empty for the only one.
        of_host: it is the host's side; the checker is the target then.
        machines: which state machines on its benches are its own, by the names of their states; all if empty.
        ports: what stands for it on a command line where it is somebody else's; no such bench if empty.
        program: makes the host that somebody else would start, at a port; where it is the host's side.
        tell: has it tell what it understood on a line of its own, as a host may that is written to be checked.
    beside: makes a bench with it at a port and somebody beside it, who is asked; None where nobody can be.
    """

    name: str
    title: str
    protocol: str
    bench: str
    suites: tuple[str, ...] = ()
    select: str = ""
    line: str = ""
    of_host: bool = False
    machines: frozenset[str] = frozenset()
    ports: tuple[TargetChoice, ...] = (TargetChoice(spec="serial:/dev/none"),)
    program: Program | None = None
    tell: Tell | None = None
    beside: MakeBeside | None = None

    @property
    def by_hand(self) -> str:
        """What selects its cases that need somebody beside it, and that he makes possible."""
        return " or ".join(clause.id for clause in self.record.clauses() if getattr(clause, "by_hand", False))

    @property
    def record(self) -> ProtocolPlugin:
        """The protocol's."""
        return PLUGINS.get(self.protocol, self.name)

    def reading(self, way: Way) -> Reading:
        """Return how the frames of a direction are read, seen from the subject."""
        of_host = self.of_host == (way is Way.OUT)
        return Reading(self.record, "host" if of_host else "target")

    def has(self, machine: str) -> bool:
        """Say whether a state machine is its own."""
        return not self.machines or machine in self.machines

    def selects(self, also: str) -> str:
        """Return the expression that selects its cases, and of these some."""
        return " and ".join(f"({one})" for one in (self.select, also) if one)


_ENDS_WITHIN_NS = 1_500 * NS_PER_MS
"""How long a program that is interrupted goes on (choice): longer than it takes leave, shorter than it may take."""
_TELLING = (TargetChoice(spec="exec:client {port} {report}"),)


@dataclass(frozen=True, slots=True)
class _Beside:
    """See `MakeBeside`.

    Args:
        person: makes who stands beside the model, and is it.
        foreign: opens benches with it.
    """

    person: Callable[[], Any]
    foreign: Callable[..., BenchProvider]

    def __call__(self, shared: Shared) -> BenchProvider:
        """See `MakeBeside`."""
        person, model = self.person(), shared.bench_file.model
        assert model is not None
        operator = Operator(system_of(model).hand_requests, [person])
        return self.foreign(replace(shared, operator=operator), person.put)


def _ground_station(bench: Bench, port: Port) -> GroundStation:
    return GroundStation(bench, port, PROFILES["documented"])


def _p2os_client(bench: Bench, port: Port) -> P2osClient:
    return P2osClient(bench, port, ClientOptions())


def _car_simulator(bench: Bench, port: Port) -> CarSimulator:
    return CarSimulator(bench, port, CarHostSettings())


SUBJECTS = {
    subject.name: subject
    for subject in (
        Subject(
            name="pkt-board",
            title="PKT! board",
            protocol="pkt",
            bench="rover-model",
            suites=("pkt-board",),
            select="documented",
            beside=_Beside(lambda: BesideRover(lambda: RoverRobot(RoverSettings())), ForeignRoverInBenchTime),
        ),
        Subject(
            name="pkt-host",
            title="PKT! host",
            protocol="pkt",
            bench="rover-model",
            suites=("pkt-host",),
            of_host=True,
            program=_ground_station,
            tell=StationReporter,
            ports=_TELLING,
        ),
        Subject(
            name="p2os-server", title="P2OS server", protocol="p2os", bench="pioneer-plane", suites=("p2os-server",)
        ),
        Subject(
            name="p2os-client",
            title="P2OS client",
            protocol="p2os",
            bench="pioneer-plane",
            suites=("p2os-client",),
            of_host=True,
            program=_p2os_client,
            tell=ClientReporter,
            ports=_TELLING,
        ),
        Subject(
            name="carla-board",
            title="CARLA board",
            protocol="carla",
            bench="vehicle-model",
            suites=("vehicle-board",),
            select="hardened",
            line="usart2",
            beside=_Beside(lambda: BesideVehicle(VehicleInterface(VehicleSettings())), ForeignVehicleInBenchTime),
            ports=(
                TargetChoice(spec="serial:/dev/usart2", name="simulator"),
                TargetChoice(spec="serial:/dev/usart3", name="stack"),
            ),
        ),
        Subject(
            name="carla-host",
            title="CARLA simulator's side",
            protocol="carla",
            bench="vehicle-model",
            suites=("vehicle-host",),
            select="hardened",
            of_host=True,
            machines=frozenset({"LinkState"}),
            program=_car_simulator,
            tell=CarReporter,
            ports=_TELLING,
        ),
    )
}
"""By name."""


def bench_of(name: str, protocol: str, suites: Sequence[str]) -> Subject:
    """Return the model of any bench as a subject, as it speaks a protocol at its only line.

    Raises:
        UsageError: there is no such bench or protocol, or the bench has no model.
    """
    bench_file = open_bench(name)
    if bench_file.model is None:
        raise UsageError("has no model to be made wrong", where=name)
    return Subject(
        name=f"{bench_file.name}:{PLUGINS.get(protocol, name).name}",
        title=f"{PLUGINS.get(protocol, name).title} on {bench_file.name}",
        protocol=protocol,
        bench=name,
        suites=tuple(suites),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Relayed(Shared):
    """What all benches of a run have in common, the relay on their lines included."""

    relay: MakeRelay
    door: Callable[[Port], Port]

    def bench(self, scheduler: Scheduler) -> Bench:
        bench = Bench(scheduler, self.journal, timeout_scale=self.timeout_scale)
        bench.route = lambda port: self.relay(scheduler, self.door(port))
        return bench


@contextlib.contextmanager
def opened(
    subject: Subject, relay: MakeRelay, *, at_port: bool, by_hand: bool = False, through: str = ""
) -> Iterator[BenchProvider]:
    """Return who opens the benches of a subject, with a relay on its line.

    Args:
        subject: who is put to the test.
        relay: puts it there; called for each of the checker's lines.
        at_port: it is somebody else's.
        by_hand: and somebody stands beside it, who is asked.
        through: a door of this machine that the lines pass, one of `hilbench.terminal.options.THROUGH`.
    """
    routes = Routes(through) if through else None
    bench_file = open_bench(subject.bench)
    door = routes or (lambda port: port)
    shared = _Relayed(bench_file=bench_file, timeout_scale=1.0, journal=Journal(), relay=relay, door=door)
    assert bench_file.model is not None
    if by_hand:
        assert subject.beside is not None
        provider = subject.beside(shared)
    else:
        provider = system_of(bench_file.model).provider(shared, subject.ports if at_port else ())
    with contextlib.ExitStack() as stack:
        if routes is not None:
            stack.callback(routes.close)
        if at_port:
            stack.enter_context(_in_bench_time(bench_file))
            stack.enter_context(_started_in_bench_time(subject))
        stack.callback(provider.close)
        yield provider


class _Started:
    """A host as somebody else's program that is started for each case, in virtual time."""

    def __init__(self, provider: Any, subject: Subject) -> None:
        self._provider = provider
        self._subject = subject
        self._host: Any = None
        self.own = provider._reporting()

    def start(self) -> None:
        """Begin to connect."""
        program, bench = self._subject.program, self._provider._bench
        assert program is not None
        self._host = program(bench, self._provider._far)
        if self._subject.tell is not None:
            self._subject.tell(bench, self._host, self._provider._far_report)
        self._host.connect()

    def ended(self) -> str:
        """Return nothing: it lives and dies with its case."""
        return ""

    def disconnect(self) -> None:
        """Begin to take leave; the program ends, and its port is closed, when that has had its time."""
        if self._host is not None:
            self._host.disconnect()
            self._provider._scheduler.after(_ENDS_WITHIN_NS, self._provider._far.close, source="program")

    def close(self) -> None:
        """Leave the line: the next case has one of its own."""
        self._provider._port = None


@contextlib.contextmanager
def _started_in_bench_time(subject: Subject) -> Iterator[None]:
    """Put a host of ours in the place of a program that would be started, in virtual time."""

    def open_line(provider: Any) -> tuple[Port, str]:
        bench_file = provider._shared.bench_file
        link = MemoryLink(provider._scheduler, Line(baud=bench_file.links[0].baud), name="host")
        provider._far = link.b
        return link.a, link.a.name

    def open_report(provider: Any) -> Port:
        link = MemoryLink(provider._scheduler, Line(baud=0), name="report")
        provider._far_report = link.b
        return link.a

    def client(provider: Any) -> _Started:
        return _Started(provider, subject)

    with (
        patch.object(ExecProvider, "_open_line", open_line),
        patch.object(ExecProvider, "_open_report", open_report),
        patch.object(ExecProvider, "_client", client),
    ):
        yield


def _open_again(link: MemoryLink, scheduler: Scheduler) -> None:
    """Put a fresh end in the place of one that was closed; the other end notices."""
    link.a = MemoryPort(scheduler, link.a.name, link.line, tx_depth=None, injector=None)
    link.a.join(link.b)
    link.b.join(link.a)
    link.b.line_changed(True)


@contextlib.contextmanager
def _in_bench_time(bench_file: BenchFile) -> Iterator[None]:
    """Put the model of a bench at the far ends of what a provider takes for serial ports, in virtual time."""
    links: dict[str, MemoryLink] = {}
    ends: list[Callable[[], None]] = []

    def open_serial(provider: Any, target: SerialTarget) -> Port:
        if not links:
            served = system_of(bench_file.model).served(bench_file, scene=None, baud=None, seed=0)  # type: ignore[arg-type]
            for name, baud in served.lines.items():
                links[name] = MemoryLink(provider._scheduler, Line(baud=baud), name=name)
            ends.append(served.make(provider._bench, {name: link.b for name, link in links.items()}))
        wanted = target.url.rpartition("/")[2]
        link = next((link for name, link in links.items() if name.endswith(wanted)), next(iter(links.values())))
        if link.a.closed:
            _open_again(link, provider._scheduler)
        return link.a

    with (
        patch.object(LockedProvider, "_lock", lambda _provider: None),
        patch.object(LockedProvider, "_open_serial", open_serial),
    ):
        try:
            yield
        finally:
            for end in ends:
                end()
