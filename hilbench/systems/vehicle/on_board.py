"""A bench where an emulated board runs a vehicle interface's firmware, as the cases of its suites see it."""

from __future__ import annotations

from collections.abc import Iterable

from hilbench.benchfile.bench_file import BenchFile
from hilbench.clock import NS_PER_MS, EventClass
from hilbench.errors import InternalError
from hilbench.mcu.board_case import BoardBench
from hilbench.systems.vehicle.hands import VehicleHands
from hilbench.systems.vehicle.micro_ros_peer import stack_peer
from hilbench.systems.vehicle.micro_ros_settings import MicroRosSettings
from hilbench.systems.vehicle.simulator_peer import SimulatorPeer
from hilbench.systems.vehicle.system import CAR
from targets.parts.joystick import JoystickSettings
from targets.robots.vehicle_interface import SIMULATOR_LINE, STACK_LINE

__all__ = ["LIGHTS", "BoardHands", "VehicleOnBoard", "is_on_board", "vehicle_hands_on"]

LIGHTS = {"green": "LD1", "amber": "LD2", "red": "LD3"}
"""The lights of a NUCLEO-H753ZI (UM2407, section 6.5)."""

LAMPS = ("PE7", "PE8")
"""The pins of the left and the right lamp of our firmware; lit while high (choice)."""

SWITCH = "PF13"
"""The pin of the joystick's switch, as in the original."""

_JOYSTICK = "joystick"
_HELD_NS = 50 * NS_PER_MS
"""How long a switch is held down that somebody presses for a moment. A choice."""


class BoardHands:
    """At an emulated board with a joystick.

    Args:
        there: the bench.
        joystick: the name of the part; empty without one.
    """

    off_share = 0.0

    def __init__(self, there: BoardBench, joystick: str) -> None:
        self._there = there
        self._joystick = joystick

    def set_joystick(self, x_count: int, y_count: int) -> None:
        """See `VehicleHands`."""
        plan = self._there.emulated.bench_file.parts[self._part]
        settings = plan.settings
        assert isinstance(settings, JoystickSettings)
        x_axis, y_axis = settings.axes
        place = {"x": x_axis.deflection(x_count), "y": y_axis.deflection(y_count)}
        self._there.emulated.surroundings.parts.set(self._part, place)

    def press(self) -> None:
        """See `VehicleHands`."""
        parts, name, scheduler = self._there.emulated.surroundings.parts, self._part, self._there.bench.scheduler
        parts.set(name, {"press": 1.0})
        when_ns = self._there.bench.now_ns + _HELD_NS
        scheduler.at(when_ns, lambda: parts.set(name, {"press": 0.0}), order=EventClass.TIMER, source="hands")

    def hold(self) -> None:
        """See `VehicleHands`."""
        self._there.board.pin(SWITCH).drive(False)

    def let_go(self) -> None:
        """See `VehicleHands`."""
        self._there.board.pin(SWITCH).drive(None)

    def lights(self) -> frozenset[str]:
        """See `VehicleHands`."""
        return frozenset(name for name, light in LIGHTS.items() if self._there.board.is_lit(light))

    def lamps(self) -> tuple[bool, bool]:
        """See `VehicleHands`."""
        left, right = (self._there.board.pin(pin).level is True for pin in LAMPS)
        return left, right

    def blinking(self) -> None:
        """See `VehicleHands`."""

    def reset(self) -> None:
        """See `VehicleHands`."""
        self._there.board.reset()

    def hang(self) -> None:
        """See `VehicleHands`."""
        self._there.board.hang()

    @property
    def _part(self) -> str:
        if not self._joystick:
            raise InternalError("the bench has no joystick")
        return self._joystick


class VehicleOnBoard:
    """See the module.

    Args:
        there: the bench; its lines to the checker are those of the board's USART2 and USART3.
    """

    def __init__(self, there: BoardBench) -> None:
        bench_file = there.emulated.bench_file
        far_ends = {far.rpartition(".")[2]: far for far in bench_file.checker_lines.values()}
        ports = [there.emulated.far_ends.reacting(far_ends[line]) for line in (SIMULATOR_LINE, STACK_LINE)]
        self.there = there
        self.simulator = SimulatorPeer(there.bench, ports[0])
        self.stack = stack_peer(there.bench, ports[1], bench_file.settings_of(MicroRosSettings))
        self.hands: VehicleHands | None = BoardHands(there, _joystick_of(bench_file))


def is_on_board(bench_file: BenchFile) -> bool:
    """Say whether a board of a bench has both lines of a vehicle interface, and a car stands in its world."""
    is_car = bench_file.has_world and bench_file.world.vehicle == CAR
    return bool(bench_file.boards) and is_car and {SIMULATOR_LINE, STACK_LINE} <= _ends(bench_file)


def vehicle_hands_on(bench_file: BenchFile) -> Iterable[str]:
    """Return what a bench of boards can do for the cases of a vehicle interface."""
    if {SIMULATOR_LINE, STACK_LINE} <= _ends(bench_file) and bench_file.boards:
        yield from ("CARLA", "board", "stack", "boot", "lamps", "indicators", "line errors", "hang")
        if _joystick_of(bench_file):
            yield "joystick"


def _ends(bench_file: BenchFile) -> set[str]:
    """Return the ends of boards that lines of the checker with a name lead to."""
    return {far.rpartition(".")[2] for name, far in bench_file.checker_lines.items() if name}


def _joystick_of(bench_file: BenchFile) -> str:
    return next((name for name, plan in bench_file.parts.items() if plan.kind == _JOYSTICK), "")
