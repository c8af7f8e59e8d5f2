"""Benches of a vehicle-interface board: a fresh behavioural one for each case, in virtual time, or one at two ports."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from hilbench.bench import Bench
from hilbench.bench.checker_lines import ports_of_lines
from hilbench.bench.devices import LinesActor
from hilbench.bench.line_faults import LineFaults, plan_for
from hilbench.bench.line_peer import LinePeer
from hilbench.bench.locked_providers import FarEnd, LockedProvider, faults_between
from hilbench.bench.shared import Shared
from hilbench.bench.target_choice import CLIENTS, client_provider, first_of
from hilbench.benchfile.bench_file import BenchFile
from hilbench.benchfile.line_hooks import run_hook
from hilbench.benchfile.target_grammar import TargetKind, target_of
from hilbench.clock import Scheduler
from hilbench.errors import UnavailableError, UsageError
from hilbench.journal import Journal
from hilbench.judging.observations import Observations
from hilbench.judging.provider import BenchProvider, CaseInfo
from hilbench.judging.verdicts import NotApplicable
from hilbench.links import Line, MemoryLink, parse_serial_target
from hilbench.nearest import did_you_mean
from hilbench.systems.vehicle.car_simulator import OWN_HOST_CAPABILITIES, HostFactory, make_host
from hilbench.systems.vehicle.cases import (
    AttachedVehicleCase,
    CarHostCase,
    PairCase,
    VehicleFactory,
    VirtualVehicleCase,
    car_host_settings,
    fault_link,
    host_settings,
    line_baud,
    make_vehicle,
    open_car_host,
)
from hilbench.systems.vehicle.hands import HANDS, OperatorHands
from hilbench.systems.vehicle.micro_ros_peer import stack_peer
from hilbench.systems.vehicle.micro_ros_settings import MicroRosSettings
from hilbench.systems.vehicle.observing import VehicleObserver
from hilbench.systems.vehicle.reporting_car import REPORTED_CAPABILITIES, ReportingCar
from hilbench.systems.vehicle.simulator_peer import BoardPeer, SimulatorPeer
from hilbench.systems.vehicle.stack_peer import StackPeer
from hilbench.terminal.options import TargetChoice
from protocols.carla import BAUD
from targets.robots.vehicle_interface import PROFILE_NAMES, SIMULATOR_LINE, STACK_LINE, VehicleSettings

__all__ = [
    "MODEL_TARGET",
    "AttachedVehicleProvider",
    "VehicleProvider",
    "foreign_simulator",
    "model_provider",
    "settings_of",
    "vehicle_lines",
]

MODEL_TARGET = "vehicle-model"
"""A ``--target`` that is the model, ``vehicle-model:PROFILE`` in one profile."""


def model_provider(shared: Shared, choices: Sequence[TargetChoice]) -> BenchProvider:
    """Return who checks the model of a board, or what is chosen in the place of it.

    Raises:
        UsageError: nothing of this kind can be.
    """
    settings_of(shared.bench_file)  # or it is no bench for this
    targets = [target_of(choice) for choice in choices]
    kinds = {target.kind for target in targets}
    if all(target.name == MODEL_TARGET for target in targets):
        return VehicleProvider(shared, [choice for choice in choices if choice.spec != MODEL_TARGET])
    if kinds == {TargetKind.SERIAL}:
        return AttachedVehicleProvider(shared, choices)
    if len(targets) > 1 and kinds <= CLIENTS:
        raise UsageError("one simulator's side at a time", where=choices[1].where, hint="name only one")
    if len(targets) > 1:
        choice = first_of(choices, {*TargetKind} - {TargetKind.SERIAL})
        raise UsageError("each line needs a serial port", where=choice.where, hint="write LINE=serial:PORT for each")
    own = f"interface.PROFILE={MODEL_TARGET}:PROFILE"
    return client_provider(shared, choices[0], foreign_simulator(shared), own)


class VehicleProvider:
    """Gives each case a fresh behavioural board of the profile it asks for, or a fresh simulator's side.

    Args:
        shared: bench file, journal, waiting.
        choices: which profile to run where a case asks for another: ``interface.v0=vehicle-model:v1``.
        settings: other ones than those of the bench file.
        make_vehicle: makes the board.
        make_host: makes the simulator's side.

    Raises:
        UsageError: a choice fits nothing.
    """

    def __init__(
        self,
        shared: Shared,
        choices: Sequence[TargetChoice] = (),
        *,
        settings: VehicleSettings | None = None,
        make_vehicle: VehicleFactory = make_vehicle,
        make_host: HostFactory = make_host,
    ) -> None:
        self._shared = shared
        self._settings = settings or settings_of(shared.bench_file)
        self._make_vehicle = make_vehicle
        self._make_host = make_host
        self._instead = dict(_instead(choice, shared.bench_file) for choice in choices)
        self._observer = VehicleObserver()

    @property
    def capabilities(self) -> frozenset[str]:
        """Everything, in every profile."""
        programs = {f"program '{name}'" for name in PROFILE_NAMES}
        return HANDS | OWN_HOST_CAPABILITIES | {"CARLA", "board", "stack", *programs}

    @property
    def suites(self) -> Sequence[str]:
        """The suites of the bench file."""
        return self._shared.suites

    @property
    def recorded_in(self) -> Journal:
        """Where its cases are recorded."""
        return self._shared.journal

    def describe(self) -> Mapping[str, str]:
        """Name the bench and its target."""
        defects = ", ".join(self._settings.defects)
        target = "behavioural vehicle interface" + (f" with {defects}" if defects else "")
        about = self._shared.describe(target, "none")
        instead = ", ".join(f"{profile}: {other}" for profile, other in self._instead.items())
        return {**about, "instead": instead} if instead else about

    @contextlib.contextmanager
    def open_case(self, case: CaseInfo) -> Iterator[VirtualVehicleCase | CarHostCase | PairCase]:
        """Open a bench for one case."""
        bench = self._shared.bench(Scheduler())
        if {"simulator", "board"} <= case.needs:
            yield from self._pair_case(bench, case)
            return
        if "simulator" in case.needs:
            opened, simulator = open_car_host(self._shared, bench, case, self._make_host)
            yield opened
            self._observer.take_host(simulator)
            return
        made: VirtualVehicleCase | None = None

        def interrupted() -> None:
            if made is not None:
                made.simulator.line_expected = made.stack.line_expected = False

        faults = self._shared.line_faults(bench, case, near_is_client=True, on_interruption=interrupted)
        made = VirtualVehicleCase(
            bench,
            case,
            self.settings_of(case),
            self._lines,
            make_vehicle=self._make_vehicle,
            faults=faults,
            links=_fault_links(self._shared.bench_file),
        )
        yield made
        self._observer.take_board(made.board)

    def observed(self) -> Observations:
        """Return how much of the state tables the cases went through."""
        return Observations(coverage=self._observer.coverage())

    def close(self) -> None:
        """Close what the benches of the run had in common."""
        self._shared.close()

    def settings_of(self, case: CaseInfo) -> VehicleSettings:
        """Return those of the board in the profile that a case asks for, or in what takes its place."""
        profile = case.setup.program or self._settings.profile
        return replace(self._settings, profile=self._instead.get(profile, profile))  # type: ignore[arg-type]

    @property
    def _lines(self) -> tuple[Line, Line]:
        bench_file = self._shared.bench_file
        return Line(baud=line_baud(bench_file, SIMULATOR_LINE)), Line(baud=line_baud(bench_file, STACK_LINE))

    def _pair_case(self, bench: Bench, case: CaseInfo) -> Iterator[PairCase]:
        """Open a bench where board and simulator's side have each other."""
        faults = self._shared.line_faults(bench, case, near_is_client=True)
        numbers = _fault_links(self._shared.bench_file)
        links = {
            name: MemoryLink(bench.scheduler, line, name=name, faults=plan_for(faults, number))
            for name, line, number in zip((SIMULATOR_LINE, STACK_LINE), self._lines, numbers, strict=True)
        }
        board = self._make_vehicle(self.settings_of(case))
        LinesActor(bench, board, {name: link.b for name, link in links.items()}, name="board")
        to_board, to_stack = links[SIMULATOR_LINE].a, links[STACK_LINE].a
        settings = host_settings(self._shared.bench_file, case)
        opened = PairCase(bench, case, to_board, to_stack, settings, make_host=self._make_host, faults=faults)
        yield opened
        self._observer.take_board(board)
        self._observer.take_host(opened.simulator)


class AttachedVehicleProvider(LockedProvider):
    """A board that somebody else runs: its lines at two serial ports, or behind any pyserial URLs.

    The ports are opened once, before the first case; between cases the board is settled.

    Args:
        shared: bench file, journal, waiting.
        choices: the port of each line.

    Raises:
        UsageError: a line has no port, or two.
    """

    def __init__(self, shared: Shared, choices: Sequence[TargetChoice]) -> None:
        lines = vehicle_lines(shared.bench_file)
        specs = ports_of_lines(lines, choices)
        super().__init__(shared, ", ".join(f"{line} at {specs[line]}" for line in lines))
        settings = shared.bench_file.port.settings
        self._serial = [parse_serial_target(specs[line], BAUD, settings) for line in lines]
        self._peers: tuple[SimulatorPeer, StackPeer] | None = None

    @property
    def capabilities(self) -> frozenset[str]:
        """Its lines, in the one profile that it has."""
        return frozenset({"CARLA", "board", "stack", f"program '{self._profile}'"})

    @property
    def by_hand(self) -> frozenset[str]:
        """What the operator brings."""
        return frozenset() if self._shared.operator is None else self._shared.operator.capabilities

    @property
    def _profile(self) -> str:
        """The one of the model on the bench; a bench of boards has the hardened one."""
        settings = self._shared.bench_file.settings_of(VehicleSettings)
        return "hardened" if settings is None else settings.profile

    def prepare(self, cases: Sequence[CaseInfo]) -> None:
        """Open the ports before anything runs, so that one that is not there costs a line and no case.

        Raises:
            UnavailableError: one cannot be opened.
        """
        if cases:
            self._opened()

    def _opened(self) -> tuple[SimulatorPeer, StackPeer]:
        if self._peers is None:
            to_simulator, to_stack = (self._open_serial(serial) for serial in self._serial)
            settings = self._shared.bench_file.settings_of(MicroRosSettings)
            self._peers = SimulatorPeer(self._bench, to_simulator), stack_peer(self._bench, to_stack, settings)
            self._lock()
            run_hook(self._bench, to_simulator, "boot", self._shared.bench_file.port.boot)
        return self._peers

    @contextlib.contextmanager
    def open_case(self, case: CaseInfo) -> Iterator[AttachedVehicleCase]:
        """Settle the board and hand it to one case."""
        peers = self._opened()
        self._await_return(peers)
        beside = self._operator_for(case)
        run_hook(self._bench, peers[0].port, "reset", self._shared.bench_file.port.reset)
        self._settle()
        with contextlib.ExitStack() as opened:
            faults = self._strike(case, peers, opened)
            hands = None if beside is None else OperatorHands(beside)
            if hands is not None and "boot" in case.by_hand:
                hands.boot(*peers)
                opened.callback(_boot_again, hands, peers[1])
            yield AttachedVehicleCase(self._bench, case, *peers, faults, hands)

    def close(self) -> None:
        """Leave the board in manual mode, if that can be done; close everything."""
        if self._peers is not None:
            with contextlib.suppress(UnavailableError):
                self._settle()
            for peer in self._peers:
                peer.port.close()
        super().close()

    def _strike(
        self, case: CaseInfo, peers: Sequence[LinePeer[Any]], opened: contextlib.ExitStack
    ) -> LineFaults | None:
        """Put the bench file's faults on the lines for as long as a case lasts."""

        def interrupted() -> None:
            for peer in peers:
                peer.line_expected = False

        faults = self._shared.line_faults(self._bench, case, near_is_client=True, on_interruption=interrupted)
        if faults is not None:
            for peer, link in zip(peers, _fault_links(self._shared.bench_file), strict=True):
                opened.enter_context(faults_between(peer, faults, link))
        return faults

    def _settle(self) -> None:
        assert self._peers is not None
        simulator, stack = self._peers
        simulator.settle()
        stack.settle()
        simulator.forget()


def _boot_again(hands: OperatorHands, stack: StackPeer) -> None:
    with contextlib.suppress(NotApplicable):
        hands.boot_again(stack)


def vehicle_lines(bench_file: BenchFile) -> tuple[str, str]:
    """Return the names of the checker's lines that lead to the simulator's and the driving stack's end of a board.

    Raises:
        UsageError: one of them is missing.
    """
    names = {far.rpartition(".")[2]: name for name, far in bench_file.checker_lines.items()}
    for line in (SIMULATOR_LINE, STACK_LINE):
        if not names.get(line):
            hint = f'add [[links]] with ends = ["peer.LINE", "NAME.{line}"]'
            where = str(bench_file.path or bench_file.name)
            raise UsageError(f"no line of the checker, with a name, leads to {line}", where=where, hint=hint)
    return names[SIMULATOR_LINE], names[STACK_LINE]


def foreign_simulator(shared: Shared) -> FarEnd:
    """Return what a foreign simulator's side finds at the far end of its line."""
    profile = car_host_settings(shared.bench_file).profile
    return FarEnd(
        serve=BoardPeer,
        case=CarHostCase,
        capabilities=frozenset({"CARLA", "simulator", f"program '{profile}'"}),
        reporting=ReportingCar,
        reported_capabilities=REPORTED_CAPABILITIES,
    )


def _fault_links(bench_file: BenchFile) -> tuple[int | None, int | None]:
    return fault_link(bench_file, SIMULATOR_LINE), fault_link(bench_file, STACK_LINE)


def settings_of(bench_file: BenchFile) -> VehicleSettings:
    """Return what the board of a bench file is set to.

    Raises:
        UsageError: it has none.
    """
    settings = bench_file.settings_of(VehicleSettings)
    if settings is None:
        raise UsageError("names no vehicle interface among its targets", where=str(bench_file.path))
    return settings


def _instead(choice: TargetChoice, bench_file: BenchFile) -> tuple[str, str]:
    """Return a profile, and the one that runs where a case asks for it."""
    where = choice.where
    name = next((name for name, target in bench_file.targets.items() if isinstance(target.settings, VehicleSettings)))
    known = [f"{name}.{profile}" for profile in PROFILE_NAMES]
    if not choice.name:
        hint = f"write --target {known[0]}={choice.spec} (or {' or '.join(known[1:])})"
        raise UsageError("does not say which profile it replaces", where=where, hint=hint)
    if choice.name not in known:
        raise UsageError("nothing of that name to replace", where=where, hint=did_you_mean(choice.name, known, "write"))
    profile = target_of(choice).rest
    if profile not in PROFILE_NAMES:
        raise UsageError(f"no profile '{profile}'", where=where, hint=did_you_mean(profile, PROFILE_NAMES, "profiles"))
    return choice.name.partition(".")[2], profile
