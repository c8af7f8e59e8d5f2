"""What stands on a live bench of a vehicle interface: the board, a car at one line of it, a driving stack at the other.

The model has no world of its own, nor has a board at two ports: their car drives on a plane along the line of the test
track, where nothing stands.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from hilbench.bench import Bench
from hilbench.bench.about import about_world
from hilbench.bench.devices import LinesActor
from hilbench.bench.state_reporter import Observed, Senses, describe_machine
from hilbench.bench.world_runner import WorldRunner
from hilbench.benchfile.bench_file import BenchFile
from hilbench.benchfile.bench_model import World as WorldEntry
from hilbench.driving.real_port import open_at
from hilbench.driving.rig import Rig
from hilbench.driving.tap import Tap
from hilbench.links import Line, MemoryLink, Port
from hilbench.mcu.bare_vehicle import BareVehicle
from hilbench.systems.vehicle.board_views import (
    BOARD_SENSES,
    LINK_SENSES,
    BoardFromOutside,
    BoardLink,
    BoardModes,
    ControlTask,
)
from hilbench.systems.vehicle.cases import line_baud
from hilbench.systems.vehicle.driven_car import DrivenCar
from hilbench.systems.vehicle.driver import CarCrew, CarDriver
from hilbench.systems.vehicle.hands import ModelHands, VehicleHands
from hilbench.systems.vehicle.micro_ros import MicroRosEnd
from hilbench.systems.vehicle.micro_ros_peer import driving_stack
from hilbench.systems.vehicle.micro_ros_settings import MicroRosSettings
from hilbench.systems.vehicle.provider import settings_of
from hilbench.systems.vehicle.system import CAR, TRACK
from protocols.carla import BAUD
from targets.robots.driving_stack import Path, PathDriver
from targets.robots.vehicle_interface import SIMULATOR_LINE, STACK_LINE, VehicleInterface
from worlds.scenes import Lane, find_scene
from worlds.vehicles.car import CarBody

if TYPE_CHECKING:
    from hilbench.mcu.emulated import EmulatedBench

__all__ = ["SIMULATOR", "STACK", "LiveVehicle", "attached_rig", "attached_vehicle", "board_rig", "model_rig"]

_POINT_EVERY_M = 2.0
SIMULATOR, STACK = "simulator", "stack"
"""The lines, as the journal names them; the car is at the first of them."""


class LiveVehicle:
    """The board's peers, and what is seen of the board.

    Args:
        bench: whose time passes.
        ports: the far ends of the board's lines, by `SIMULATOR` and `STACK`.
        body: the car.
        runner: who moves its world.
        hands: who stands beside the board; None where that is a person.
        board: the behavioural board; None where firmware runs, which nobody looks into.
        seed: decides what chance decides in faults.
        micro_ros: the agent at the driving stack's line; None for the stand-in link.

    Attributes:
        taps: our ends of the lines.
        machines: the state machines to be seen.
        senses: what the ends of their timers mean.
        about: what the header of the journal says.
    """

    def __init__(
        self,
        bench: Bench,
        ports: Mapping[str, Port],
        body: CarBody,
        runner: WorldRunner,
        hands: VehicleHands | None,
        board: VehicleInterface | None,
        *,
        seed: int,
        micro_ros: MicroRosSettings | None = None,
    ) -> None:
        self._bench = bench
        speakers = {SIMULATOR: "car", STACK: "stack"}
        self.taps = {line: Tap(bench, ports[line], who, seed=seed, far="board") for line, who in speakers.items()}
        lane = body.world.scene.lane or _line_of_track()
        start = body.world.scene.start
        self.crew = CarCrew(
            car=DrivenCar(bench, self.taps[SIMULATOR], body, runner),
            stack=driving_stack(bench, self.taps[STACK], micro_ros),
            path=PathDriver(Path(lane.center_m, closed=lane.closed)),
            hands=hands,
            start=start,
        )
        agent = self.crew.stack.connection
        if isinstance(agent, MicroRosEnd):
            bench.tables["agent"] = agent.tables.look
        self._outside: BoardFromOutside | None = None
        self.machines: Mapping[str, Observed] = {
            "board": BoardModes(board) if board is not None else self._outside_view(),
            "car": self.crew.car.simulator.host.connection,
            "stack": self.crew.stack.observed,
            **({} if board is None else {"board link": BoardLink(board), "task": ControlTask(board)}),
        }
        self.senses: Senses = {"board": BOARD_SENSES if board is not None else {}, "board link": LINK_SENSES}
        described = {name: describe_machine(one) for name, one in self.machines.items()}
        described["board"]["seen"] = "from its frames" if board is None else ""
        if board is not None:
            described["board link"]["source"] = "board"
        protocols = {"car": "carla", "stack": "autoware" if micro_ros is None else "xrce"}
        self.about: Mapping[str, Any] = {
            "speakers": {who: {"protocol": protocols[who], "line": line} for line, who in speakers.items()},
            "machines": described,
            **about_world(body.world),
            "lane": _drawn(lane),
        }

    def drive(self, demo: bool) -> CarDriver:
        """Let the crew begin."""
        on_command = _nothing if self._outside is None else self._reaching(STACK, self._outside.command_sent)
        self.driver = CarDriver(self._bench, self.crew, demo=demo, on_command=on_command)
        return self.driver

    def look(self) -> Mapping[str, object]:
        """Return what a person would see; see `CarDriver.look`."""
        return self.driver.look()

    def _outside_view(self) -> BoardFromOutside:
        """Return what is known of a board that nobody looks into, and give it what its peers hear and send."""
        outside = self._outside = BoardFromOutside(self._bench)
        self.crew.car.simulator.on_published = lambda one: outside.frame(one.mode)
        sent = self._reaching(SIMULATOR, outside.status_sent)
        self.taps[SIMULATOR].on_sent = lambda _data, _at_ns: sent()
        return outside

    def _reaching(self, line: str, notify: Callable[[], None]) -> Callable[[], None]:
        """Notify as long as a line is up: what is sent on one that is down reaches nobody."""
        tap = self.taps[line]
        return lambda: notify() if tap.line_is_up else None


def board_rig(emulated: EmulatedBench, *, seed: int) -> Rig:
    """Put a car and a driving stack to the lines of an emulated board, and somebody beside it."""
    from hilbench.mcu.board_case import BoardBench
    from hilbench.systems.vehicle.on_board import VehicleOnBoard

    there = BoardBench(emulated)
    vehicle = VehicleOnBoard(there)
    body, runner = emulated.surroundings.body, emulated.surroundings.runner
    assert isinstance(body, CarBody)
    assert runner is not None
    assert vehicle.hands is not None
    ports = {SIMULATOR: vehicle.simulator.port, STACK: vehicle.stack.port}
    micro_ros = emulated.bench_file.settings_of(MicroRosSettings)
    live = LiveVehicle(emulated.bench, ports, body, runner, vehicle.hands, None, seed=seed, micro_ros=micro_ros)
    return _rig(live)


def attached_rig(bench: Bench, bench_file: BenchFile, specs: Mapping[str, str], *, seed: int) -> Rig:
    """Put a car and a driving stack to the lines of a board that somebody else runs; he has joystick and lights."""
    with contextlib.ExitStack() as undo:
        ports: dict[str, Port] = {}
        for name, spec in specs.items():
            port = open_at(bench, bench_file, spec, BAUD)
            ports[name] = port
            undo.callback(port.close)
        settings = bench_file.settings_of(MicroRosSettings)
        vehicle, world = attached_vehicle(bench, ports, seed=seed, micro_ros=settings)
        undo.callback(world.close)
        return _rig(vehicle, demo=False, close=undo.pop_all().close)


def attached_vehicle(
    bench: Bench, ports: Mapping[str, Port], *, seed: int, micro_ros: MicroRosSettings | None = None
) -> tuple[LiveVehicle, BareVehicle]:
    """Put a car on a plane and a driving stack to the far ends of a board's lines, by `SIMULATOR` and `STACK`."""
    world, body = _car_on_plane(bench, seed)
    return LiveVehicle(bench, ports, body, world.runner, None, None, seed=seed, micro_ros=micro_ros), world


def model_rig(bench: Bench, bench_file: BenchFile, *, seed: int) -> Rig:
    """Build the behavioural board of a bench file, and a car for it on a plane."""
    settings = settings_of(bench_file)
    world, body = _car_on_plane(bench, seed)
    names = {SIMULATOR: SIMULATOR_LINE, STACK: STACK_LINE}
    links = {
        name: MemoryLink(bench.scheduler, Line(baud=line_baud(bench_file, line)), name=line)
        for name, line in names.items()
    }
    board = VehicleInterface(settings)
    actor = LinesActor(bench, board, {line: links[name].b for name, line in names.items()}, name="board")
    links[SIMULATOR].b.on_break = lambda at_ns: actor.transmit(board.line_error(at_ns))
    hands = ModelHands(bench, board, actor)
    ports = {name: link.a for name, link in links.items()}
    vehicle = LiveVehicle(bench, ports, body, world.runner, hands, board, seed=seed)
    return _rig(vehicle, reset=hands.reset, close=world.close)


def _rig(vehicle: LiveVehicle, **more: Any) -> Rig:
    return Rig(
        taps=vehicle.taps,
        machines=vehicle.machines,
        senses=vehicle.senses,
        views={"vehicle": vehicle.look},
        about=vehicle.about,
        drive=vehicle.drive,
        **more,
    )


def _car_on_plane(bench: Bench, seed: int) -> tuple[BareVehicle, CarBody]:
    world = BareVehicle(bench, WorldEntry(scene="empty", vehicle=CAR, physics="plane"), seed=seed)
    assert isinstance(world.body, CarBody)
    return world, world.body


def _line_of_track() -> Lane:
    lane = find_scene(TRACK).lane
    assert lane is not None
    return lane


def _drawn(lane: Lane) -> dict[str, Any]:
    """Return a lane as it is drawn: a point now and then is enough."""
    points, gone_m = [lane.center_m[0]], 0.0
    for before, point in zip(lane.center_m, lane.center_m[1:], strict=False):
        gone_m += ((point[0] - before[0]) ** 2 + (point[1] - before[1]) ** 2) ** 0.5
        if gone_m >= _POINT_EVERY_M:
            points.append(point)
            gone_m = 0.0
    center = [[round(x, 2), round(y, 2)] for x, y in points]
    return {"center": center, "width_m": lane.width_m, "closed": lane.closed}


def _nothing() -> None:
    """Nobody is notified."""
