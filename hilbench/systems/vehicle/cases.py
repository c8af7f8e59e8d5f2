"""The bench of one case of the vehicle-interface board, or of the simulator's side of its line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from hilbench.bench import Bench
from hilbench.bench.cases import CaseBase
from hilbench.bench.devices import LinesActor
from hilbench.bench.line_faults import LineFaults, plan_for
from hilbench.bench.line_peer import LinePeer
from hilbench.bench.shared import Shared
from hilbench.bench.state_reporter import Observed, Senses
from hilbench.bench.under_test import UnderTest
from hilbench.benchfile.bench_file import BenchFile
from hilbench.judging.provider import CaseInfo
from hilbench.links import Line, MemoryLink, Port
from hilbench.systems.vehicle.about import about_vehicle_lines
from hilbench.systems.vehicle.board_views import BOARD_SENSES, LINK_SENSES, BoardLink, BoardModes, ControlTask
from hilbench.systems.vehicle.car_simulator import CarSimulator, HostFactory, OwnCarHost, make_host
from hilbench.systems.vehicle.hands import ModelHands, VehicleHands
from hilbench.systems.vehicle.micro_ros_peer import stack_peer
from hilbench.systems.vehicle.micro_ros_settings import MicroRosSettings
from hilbench.systems.vehicle.reporting_car import ReportingCar
from hilbench.systems.vehicle.simulator_peer import BoardPeer, SimulatorPeer
from hilbench.systems.vehicle.stack_peer import StackPeer
from protocols.carla import BAUD
from targets.robots.car_host import CarHostSettings
from targets.robots.vehicle_interface import SIMULATOR_LINE, STACK_LINE, VehicleInterface, VehicleSettings

__all__ = [
    "AttachedVehicleCase",
    "CarHostCase",
    "PairCase",
    "VehicleCase",
    "VehicleFactory",
    "VirtualVehicleCase",
    "car_host_settings",
    "fault_link",
    "host_settings",
    "line_baud",
    "make_vehicle",
    "open_car_host",
]

VehicleFactory = Callable[[VehicleSettings], VehicleInterface]


def make_vehicle(settings: VehicleSettings) -> VehicleInterface:
    """Make the board as it is meant to be; what takes its place in a test may be a faulty one."""
    return VehicleInterface(settings)


def line_baud(bench_file: BenchFile, line: str) -> int:
    """Return the rate of the line of a model whose end ends with ``.LINE``, in bit/s."""
    found = (link.baud for link in bench_file.links for end in link.ends if end.endswith(f".{line}"))
    return next(found, BAUD)


def fault_link(bench_file: BenchFile, line: str) -> int | None:
    """Return which link of the bench file is a line of the board, for its faults; None if the file has none for it."""
    return bench_file.link_of(line, (SIMULATOR_LINE, STACK_LINE))


def car_host_settings(bench_file: BenchFile) -> CarHostSettings:
    """Return what the simulator's side of a bench file is set to; the usual where it does not stand there."""
    return bench_file.settings_of(CarHostSettings) or CarHostSettings()


def host_settings(bench_file: BenchFile, case: CaseInfo) -> CarHostSettings:
    """Return what the simulator's side is set to, in the profile that a case asks for."""
    settings = car_host_settings(bench_file)
    return replace(settings, profile=case.setup.program) if case.setup.program else settings  # type: ignore[arg-type]


class VehicleCase(CaseBase):
    """What every case of a board has.

    Attributes:
        simulator: the checker's end of the simulator's line.
        stack: the checker's end of the driving stack's line.
        hands: who stands beside the board; None if nobody does.
    """

    simulator: SimulatorPeer
    stack: StackPeer
    hands: VehicleHands | None = None

    def _peers(self) -> Mapping[str, LinePeer[Any]]:
        return {SIMULATOR_LINE: self.simulator, STACK_LINE: self.stack}

    def _about_view(self) -> Mapping[str, Any]:
        return about_vehicle_lines({SIMULATOR_LINE: SIMULATOR_LINE, STACK_LINE: STACK_LINE})


class VirtualVehicleCase(VehicleCase):
    """A behavioural board on a bench of its own, power just on, where nothing is real and time runs free.

    Args:
        bench: made for this case alone.
        case: what is known of it.
        settings: of the board.
        lines: the simulator's line and the driving stack's.
        make_vehicle: makes the board.
        faults: what goes wrong on the lines.
        links: which links of the bench file these are, for the faults.

    Attributes:
        board: the board.
    """

    _senses: Senses = MappingProxyType({"board": BOARD_SENSES, "board link": LINK_SENSES})

    def __init__(
        self,
        bench: Bench,
        case: CaseInfo,
        settings: VehicleSettings,
        lines: tuple[Line, Line],
        *,
        make_vehicle: VehicleFactory = make_vehicle,
        faults: LineFaults | None = None,
        links: tuple[int | None, int | None] = (0, 1),
    ) -> None:
        super().__init__(bench, case, faults)
        to_simulator, to_stack = (
            MemoryLink(bench.scheduler, line, name=name, faults=plan_for(faults, link))
            for line, name, link in zip(lines, (SIMULATOR_LINE, STACK_LINE), links, strict=True)
        )
        self.simulator = SimulatorPeer(bench, to_simulator.a)
        self.stack = StackPeer(bench, to_stack.a)
        self.board = make_vehicle(settings)
        ports: dict[str, Port] = {SIMULATOR_LINE: to_simulator.b, STACK_LINE: to_stack.b}
        actor = LinesActor(bench, self.board, ports, name="board")
        # A break is a frame without its stop bit: what the board's UART calls a framing error.
        to_simulator.b.on_break = lambda at_ns: actor.transmit(self.board.line_error(at_ns))
        self.hands = ModelHands(bench, self.board, actor)

    def _machines_seen(self) -> Mapping[str, Observed]:
        board = self.board
        return {"board": BoardModes(board), "board link": BoardLink(board), "task": ControlTask(board)}


class AttachedVehicleCase(VehicleCase):
    """A board that somebody else runs, in real time, at two ports.

    Args:
        bench: shared by all cases, locked to the host's clock.
        case: what is known of this one.
        simulator: the checker's end of the simulator's line, settled.
        stack: the same of the driving stack's.
        faults: what goes wrong on the lines.
        hands: who stands beside the board; None if nobody does.
    """

    def __init__(
        self,
        bench: Bench,
        case: CaseInfo,
        simulator: SimulatorPeer,
        stack: StackPeer,
        faults: LineFaults | None = None,
        hands: VehicleHands | None = None,
    ) -> None:
        super().__init__(bench, case, faults)
        self.hands = hands
        self.simulator = simulator
        self.stack = stack


class CarHostCase(CaseBase):
    """What every case of a simulator's side has: the checker is the board at the far end of its line.

    Args:
        bench: whose time passes.
        case: what is known of it.
        board: the checker's end of the line.
        client: the simulator's side under test.
        faults: what goes wrong on the line.
    """

    def __init__(
        self,
        bench: Bench,
        case: CaseInfo,
        board: BoardPeer,
        client: UnderTest[CarSimulator | ReportingCar],
        faults: LineFaults | None = None,
    ) -> None:
        super().__init__(bench, case, faults)
        self.board = board
        self.client = client

    def _peers(self) -> Mapping[str, LinePeer[Any]]:
        return {SIMULATOR_LINE: self.board}


class PairCase(CaseBase):
    """Our own simulator's side, begun, with the board of the bench at the far end; the checker is the driving stack.

    Args:
        bench: whose time passes.
        case: what is known of it.
        to_board: the simulator's end of the board's line.
        to_stack: the driving stack's end of the board's other line.
        settings: of the simulator's side.
        make_host: makes it.
        faults: what goes wrong on the lines.
        micro_ros: the agent at the driving stack's line; None for the stand-in link.

    Attributes:
        simulator: the simulator's side, which says nothing of its car by itself.
        stack: the checker's end of the other line.
    """

    def __init__(
        self,
        bench: Bench,
        case: CaseInfo,
        to_board: Port,
        to_stack: Port,
        settings: CarHostSettings,
        *,
        make_host: HostFactory = make_host,
        faults: LineFaults | None = None,
        micro_ros: MicroRosSettings | None = None,
    ) -> None:
        super().__init__(bench, case, faults)
        self.simulator = CarSimulator(bench, to_board, settings, make_host=make_host)
        self.simulator.connect()
        self.simulator.report_by_hand()
        self.stack = stack_peer(bench, to_stack, micro_ros)

    def _peers(self) -> Mapping[str, LinePeer[Any]]:
        return {STACK_LINE: self.stack}


def open_car_host(
    shared: Shared, bench: Bench, case: CaseInfo, make_host: HostFactory = make_host
) -> tuple[CarHostCase, CarSimulator]:
    """Open the bench of one case with our own simulator's side under test, and the checker as its board."""
    bench_file = shared.bench_file
    faults = shared.line_faults(bench, case, near_is_client=False)
    line = Line(baud=line_baud(bench_file, SIMULATOR_LINE))
    plan = plan_for(faults, fault_link(bench_file, SIMULATOR_LINE))
    link = MemoryLink(bench.scheduler, line, name=SIMULATOR_LINE, faults=plan)
    simulator = CarSimulator(bench, link.b, host_settings(bench_file, case), make_host=make_host)
    return CarHostCase(bench, case, BoardPeer(bench, link.a), OwnCarHost(simulator), faults), simulator
