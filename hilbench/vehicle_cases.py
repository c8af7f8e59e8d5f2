"""The bench of one case of the vehicle-interface board, or of the simulator's side of its line."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from hilbench.bench import Bench
from hilbench.bench_file import BenchFile
from hilbench.car_simulator import CarHostUnderTest
from hilbench.carla_peer import BoardPeer, SimulatorPeer
from hilbench.cases import CaseBase
from hilbench.check.provider import CaseInfo
from hilbench.devices import LinesActor
from hilbench.line_faults import LineFaults
from hilbench.links import Line, MemoryLink, Port
from hilbench.stack_peer import StackPeer
from hilbench.vehicle_hands import ModelHands, VehicleHands
from protocols.carla import BAUD
from targets.robots.vehicle_interface import SIMULATOR_LINE, STACK_LINE, VehicleInterface, VehicleSettings

__all__ = [
    "AttachedVehicleCase",
    "CarHostCase",
    "VehicleCase",
    "VehicleFactory",
    "VirtualVehicleCase",
    "line_baud",
    "make_vehicle",
]

VehicleFactory = Callable[[VehicleSettings], VehicleInterface]


def make_vehicle(settings: VehicleSettings) -> VehicleInterface:
    """Make the board as it is meant to be; what takes its place in a test may be a faulty one."""
    return VehicleInterface(settings)


def line_baud(bench_file: BenchFile, line: str) -> int:
    """Return the rate of the line of a model whose end ends with ``.LINE``, in bit/s."""
    found = (link.baud for link in bench_file.links for end in link.ends if end.endswith(f".{line}"))
    return next(found, BAUD)


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

    def _packets(self) -> Sequence[str]:
        return [
            *(f"simulator  {line}" for line in self.simulator.evidence()),
            *(f"stack      {line}" for line in self.stack.evidence()),
        ]


class VirtualVehicleCase(VehicleCase):
    """A behavioural board on a bench of its own, power just on, where nothing is real and time runs free.

    Args:
        bench: made for this case alone.
        case: what is known of it.
        settings: of the board.
        lines: the simulator's line and the driving stack's.
        make_vehicle: makes the board.
        faults: what goes wrong on one of the lines.
        faulty: which of them that is.

    Attributes:
        board: the board.
    """

    def __init__(
        self,
        bench: Bench,
        case: CaseInfo,
        settings: VehicleSettings,
        lines: tuple[Line, Line],
        *,
        make_vehicle: VehicleFactory = make_vehicle,
        faults: LineFaults | None = None,
        faulty: str = SIMULATOR_LINE,
    ) -> None:
        super().__init__(bench, case, faults)
        plans = {} if faults is None else {faulty: faults.plan}
        to_simulator, to_stack = (
            MemoryLink(bench.scheduler, line, name=name, faults=plans.get(name))
            for line, name in zip(lines, (SIMULATOR_LINE, STACK_LINE), strict=True)
        )
        self.simulator = SimulatorPeer(bench, to_simulator.a)
        self.stack = StackPeer(bench, to_stack.a)
        self.board = make_vehicle(settings)
        ports: dict[str, Port] = {SIMULATOR_LINE: to_simulator.b, STACK_LINE: to_stack.b}
        actor = LinesActor(bench, self.board, ports, name="board")
        # A break is a frame without its stop bit: what the board's UART calls a framing error.
        to_simulator.b.on_break = lambda at_ns: actor.transmit(self.board.line_error(at_ns))
        self.hands = ModelHands(bench, self.board, actor)


class AttachedVehicleCase(VehicleCase):
    """A board that somebody else runs, in real time, at two ports; nobody stands beside it.

    Args:
        bench: shared by all cases, locked to the host's clock.
        case: what is known of this one.
        simulator: the checker's end of the simulator's line, settled.
        stack: likewise of the driving stack's.
    """

    def __init__(self, bench: Bench, case: CaseInfo, simulator: SimulatorPeer, stack: StackPeer) -> None:
        super().__init__(bench, case)
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
        client: CarHostUnderTest,
        faults: LineFaults | None = None,
    ) -> None:
        super().__init__(bench, case, faults)
        self.board = board
        self.client = client

    def _packets(self) -> Sequence[str]:
        return self.board.evidence()
