"""The autonomous car as a system: its vehicle-interface board, the simulator's side, and the car in its world."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from hilbench.errors import UsageError
from hilbench.plugins.protocol import ClauseEntry
from hilbench.plugins.system import API, HandRequest, ModelKind, System, VehicleKind

if TYPE_CHECKING:
    from hilbench.bench import Bench
    from hilbench.bench.cases import CaseBase
    from hilbench.bench.served_targets import ServedTarget
    from hilbench.bench.shared import Shared
    from hilbench.benchfile.bench_file import BenchFile
    from hilbench.driving.rig import Rig
    from hilbench.judging.provider import BenchProvider, CaseInfo
    from hilbench.links import Port
    from hilbench.mcu.emulated import EmulatedBench
    from hilbench.plugins.dashboard import Dashboard
    from hilbench.terminal.options import TargetChoice

__all__ = ["CAR", "TRACK", "VEHICLE"]

CAR = "car"
TRACK = "test-track"


def _car() -> VehicleKind:
    from hilbench.systems.vehicle.signals import CAR_SIGNALS, CarSignals
    from worlds.vehicles import car

    return VehicleKind(
        vehicle=car.vehicle,
        body=car.CarBody,
        signals=CAR_SIGNALS,
        wire=CarSignals,
        size_m=(4.5, 1.9),
        stands_ready=True,
    )


_REQUESTS = {
    "press": HandRequest(text="press the joystick's button once and let go of it", capability="joystick"),
    "hold-joystick": HandRequest(
        text="push the joystick {} as far as it goes and hold it there", capability="joystick", undo="release-joystick"
    ),
    "release-joystick": HandRequest(text="let go of the joystick", capability="joystick"),
    "light": HandRequest(
        text="which of the board's lights is lit?",
        capability="lamps",
        answers=("green", "amber", "red", "none", "several"),
    ),
    "indicators": HandRequest(
        text="which turn indicators blink, once or twice a second?",
        capability="indicators",
        answers=("left", "right", "both", "none", "otherwise"),
    ),
    "hold-reset": HandRequest(
        text="press the board's reset button and keep it pressed", capability="boot", undo="release-reset"
    ),
    "release-reset": HandRequest(text="let go of the reset button", capability="boot"),
}


class Vehicle(System):
    """See the module."""

    api = API
    name = "vehicle"
    title = "Vehicle"
    summary = "an autonomous car's vehicle-interface board between its simulator and its driving stack"
    vehicles = MappingProxyType({CAR: _car})
    hand_requests = MappingProxyType(_REQUESTS)

    def models(self) -> Mapping[str, ModelKind]:
        """See `System`."""
        from hilbench.systems.vehicle.micro_ros_settings import MicroRosSettings
        from targets.robots.car_host import CarHostSettings
        from targets.robots.vehicle_interface import LINE_BAUD, SIMULATOR_LINE, STACK_LINE, VehicleSettings

        board = ModelKind(
            settings=VehicleSettings,
            protocol="CARLA",
            suites=("vehicle-board", "vehicle-host"),
            baud=LINE_BAUD,
            lines=(SIMULATOR_LINE, STACK_LINE),
            bench="vehicle-model",
            target="vehicle-model",
        )
        host = ModelKind(
            settings=CarHostSettings,
            protocol="CARLA",
            suites=("vehicle-host",),
            baud=LINE_BAUD,
            lines=("board",),
            beside=True,
        )
        agent = ModelKind(
            settings=MicroRosSettings,
            protocol="DDS-XRCE",
            suites=(),
            baud=LINE_BAUD,
            lines=("board",),
            beside=True,
        )
        return {"vehicle-interface": board, "car-host": host, "micro-ros-agent": agent}

    def clauses(self) -> Sequence[ClauseEntry]:
        """See `System`."""
        from hilbench.systems.vehicle.drive_clauses import CLAUSES

        return CLAUSES

    def provider(self, shared: Shared, choices: Sequence[TargetChoice]) -> BenchProvider:
        """See `System`."""
        from hilbench.systems.vehicle.provider import model_provider

        return model_provider(shared, choices)

    def board_provider(self, shared: Shared, choices: Sequence[TargetChoice]) -> BenchProvider | None:
        """See `System`."""
        from hilbench.bench.target_choice import CLIENTS, first_of
        from hilbench.benchfile.target_grammar import TargetKind, target_of
        from hilbench.systems.vehicle.provider import AttachedVehicleProvider

        kinds = {target_of(choice).kind for choice in choices}
        if kinds & CLIENTS:
            choice = first_of(choices, CLIENTS)
            raise UsageError(
                "a program in the place of the simulator's side is checked without a board, not on this bench",
                where=choice.where,
                hint=f"write hilbench check vehicle-model --suite vehicle-host --target '{choice.spec}'",
            )
        if TargetKind.SERIAL not in kinds:
            return None
        if len(kinds) > 1:
            where = first_of(choices, {TargetKind.SERIAL}).where
            raise UsageError("a board at a port stands for the whole bench", where=where, hint="name only that")
        return AttachedVehicleProvider(shared, choices)

    def board_capabilities(self, bench_file: BenchFile) -> Iterable[str]:
        """See `System`."""
        from hilbench.systems.vehicle.car_simulator import OWN_HOST_CAPABILITIES
        from hilbench.systems.vehicle.on_board import vehicle_hands_on
        from targets.robots.car_host import CarHostSettings

        yield from vehicle_hands_on(bench_file)
        if bench_file.settings_of(CarHostSettings) is not None:
            yield from OWN_HOST_CAPABILITIES

    def needs_board(self, case: CaseInfo) -> bool:
        """Say whether a board runs in a case: the checker may stand in for one if a simulator's side is under test."""
        return "simulator" not in case.needs or "board" in case.needs

    def without_board(self, shared: Shared, bench: Bench, case: CaseInfo) -> CaseBase:
        """See `System`."""
        from hilbench.systems.vehicle.cases import open_car_host

        return open_car_host(shared, bench, case)[0]

    def with_board(self, shared: Shared, case: CaseInfo, emulated: EmulatedBench) -> CaseBase | None:
        """Give a case of the simulator's side and a board our own simulator's side, with the board at its far end."""
        from hilbench.mcu.board_case import BoardBench
        from hilbench.systems.vehicle.cases import PairCase, host_settings
        from hilbench.systems.vehicle.micro_ros_settings import MicroRosSettings
        from hilbench.systems.vehicle.on_board import VehicleOnBoard

        if "simulator" not in case.needs:
            return None
        ends, settings = VehicleOnBoard(BoardBench(emulated)), host_settings(shared.bench_file, case)
        micro_ros = shared.bench_file.settings_of(MicroRosSettings)
        return PairCase(emulated.bench, case, ends.simulator.port, ends.stack.port, settings, micro_ros=micro_ros)

    def about_board(self, bench_file: BenchFile, program: str) -> Mapping[str, Any]:
        """See `System`."""
        from hilbench.systems.vehicle.about import about_vehicle_lines

        del program
        lines = bench_file.checker_lines.items()
        return about_vehicle_lines({name or "host": end.rpartition(".")[2] for name, end in lines})

    def served(self, bench_file: BenchFile, *, scene: str | None, baud: int | None, seed: int) -> ServedTarget:
        """See `System`."""
        from hilbench.bench.devices import LinesActor
        from hilbench.bench.served_targets import ServedTarget
        from hilbench.systems.vehicle.cases import line_baud
        from hilbench.systems.vehicle.provider import settings_of
        from targets.robots.vehicle_interface import SIMULATOR_LINE, STACK_LINE, VehicleInterface

        del scene, seed
        settings = settings_of(bench_file)
        name = next(name for name, target in bench_file.targets.items() if target.settings is settings)

        def make(bench: Bench, ports: Mapping[str, Port]) -> Callable[[], None]:
            ends = {end.rpartition(".")[2]: port for end, port in ports.items()}
            LinesActor(bench, VehicleInterface(settings, power_on_ns=bench.now_ns), ends, name="board")
            return lambda: None

        lines = (SIMULATOR_LINE, STACK_LINE)
        return ServedTarget({f"{name}.{line}": baud or line_baud(bench_file, line) for line in lines}, make, "board")

    def rig(self, bench: Bench, bench_file: BenchFile, *, seed: int) -> Rig:
        """See `System`."""
        from hilbench.systems.vehicle.live import model_rig

        return model_rig(bench, bench_file, seed=seed)

    def board_rig(self, emulated: EmulatedBench, *, seed: int) -> Rig | None:
        """See `System`."""
        from hilbench.systems.vehicle.live import board_rig
        from hilbench.systems.vehicle.on_board import is_on_board

        return board_rig(emulated, seed=seed) if is_on_board(emulated.bench_file) else None

    def speaks_to(self, bench_file: BenchFile) -> bool:
        """See `System`; a car and both lines of a board will do."""
        from hilbench.systems.vehicle.on_board import is_on_board

        return is_on_board(bench_file) or super().speaks_to(bench_file)

    def lines_asked(self, bench_file: BenchFile, choices: Sequence[TargetChoice]) -> Mapping[str, str]:
        """See `System`; there are two lines."""
        from hilbench.bench.checker_lines import ports_of_lines
        from hilbench.systems.vehicle.live import SIMULATOR, STACK
        from hilbench.systems.vehicle.provider import vehicle_lines

        lines = vehicle_lines(bench_file)
        specs = ports_of_lines(lines, choices)
        return {name: specs[line] for name, line in zip((SIMULATOR, STACK), lines, strict=True)}

    def attached_rig(self, bench: Bench, bench_file: BenchFile, ports: Mapping[str, str], *, seed: int) -> Rig:
        """See `System`."""
        from hilbench.systems.vehicle.live import attached_rig

        return attached_rig(bench, bench_file, ports, seed=seed)

    def scene(self, bench_file: BenchFile) -> str | None:
        """Show a car that stands on an empty floor on the test track."""
        from hilbench.systems.vehicle.on_board import is_on_board

        return TRACK if is_on_board(bench_file) and bench_file.world.scene == "empty" else None

    def dashboard(self) -> Dashboard:
        """See `System`."""
        from hilbench.systems.vehicle.dashboard import DASHBOARD

        return DASHBOARD


VEHICLE = Vehicle()
