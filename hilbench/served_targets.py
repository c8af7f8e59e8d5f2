"""Virtual targets that are no emulated boards, as something that can be put at the end of a line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from hilbench.bench import Bench
from hilbench.bench_file import BenchFile, ModelTarget
from hilbench.devices import DeviceActor, LinesActor
from hilbench.errors import UnavailableError, UsageError
from hilbench.links import Port
from hilbench.protocol_bench.cases import DEVICE, device_baud
from hilbench.systems.pioneer.robot import PioneerPlan, VirtualPioneer, plan_of
from hilbench.systems.rover.cases import rover_baud
from hilbench.systems.vehicle.cases import line_baud
from targets.robots.rover import RoverRobot
from targets.robots.vehicle_interface import SIMULATOR_LINE, STACK_LINE, VehicleInterface
from worlds.errors import WorldError

__all__ = ["ServedTarget", "served_target"]

_HOST = "host"
"""The line of a robot that has one alone."""


@dataclass(frozen=True, slots=True)
class ServedTarget:
    """A virtual target and its lines.

    Attributes:
        lines: the rate of each of its lines, bit/s, by name.
        make: brings it to life at the far ends of these lines, and returns how to end it.
        source: its source in the journal, where it has one line alone; empty else.
    """

    lines: Mapping[str, int]
    make: Callable[[Bench, Mapping[str, Port]], Callable[[], None]]
    source: str = ""


def served_target(
    bench_file: BenchFile, *, scene: str | None = None, baud: int | None = None, seed: int = 0
) -> ServedTarget:
    """Return the model of a bench file as something that can be put at the end of a line.

    Args:
        bench_file: a bench without boards.
        scene: where it stands instead of the scene of the file.
        baud: rate of its lines instead of that of the file, bit/s.
        seed: of everything random.

    Raises:
        UsageError: nothing stands in a world here, or the rate is none that the model knows.
    """
    if bench_file.plugged_in is None and bench_file.vehicle is None and bench_file.rover is None:
        return _pioneer(bench_file, scene, baud, seed)
    if scene is not None:
        raise UsageError("nothing stands in a world here", where=f"--scene {scene}")
    if bench_file.plugged_in is not None:
        return _plugged_in(bench_file, bench_file.plugged_in, baud)
    return _vehicle(bench_file, baud) if bench_file.vehicle is not None else _rover(bench_file, baud)


def _pioneer(bench_file: BenchFile, scene: str | None, baud: int | None, seed: int) -> ServedTarget:
    plan = _plan(bench_file, scene, baud)

    def make(bench: Bench, ports: Mapping[str, Port]) -> Callable[[], None]:
        try:
            return VirtualPioneer(bench, ports[_HOST], plan, seed=seed).close
        except WorldError as error:
            raise UnavailableError(str(error), where=f"scene {plan.scene}") from error

    return ServedTarget({_HOST: plan.settings.host_baud}, make, "robot")


def _vehicle(bench_file: BenchFile, baud: int | None) -> ServedTarget:
    settings = bench_file.vehicle
    assert settings is not None
    name = next(name for name, target in bench_file.targets.items() if target.settings is settings)

    def make(bench: Bench, ports: Mapping[str, Port]) -> Callable[[], None]:
        ends = {end.rpartition(".")[2]: port for end, port in ports.items()}
        LinesActor(bench, VehicleInterface(settings, power_on_ns=bench.now_ns), ends, name="board")
        return lambda: None

    lines = (SIMULATOR_LINE, STACK_LINE)
    return ServedTarget({f"{name}.{line}": baud or line_baud(bench_file, line) for line in lines}, make)


def _rover(bench_file: BenchFile, baud: int | None) -> ServedTarget:
    settings = bench_file.rover
    assert settings is not None

    def make(bench: Bench, ports: Mapping[str, Port]) -> Callable[[], None]:
        DeviceActor(bench, RoverRobot(settings), ports[_HOST], name="rover")
        return lambda: None

    return ServedTarget({_HOST: baud or rover_baud(bench_file)}, make, "rover")


def _plugged_in(bench_file: BenchFile, target: ModelTarget, baud: int | None) -> ServedTarget:
    protocol = target.protocol
    assert protocol is not None
    assert protocol.device is not None
    device = protocol.device

    def make(bench: Bench, ports: Mapping[str, Port]) -> Callable[[], None]:
        DeviceActor(bench, device.make(target.settings), ports[_HOST], name=DEVICE)
        return lambda: None

    return ServedTarget({_HOST: baud or device_baud(bench_file, protocol)}, make, DEVICE)


def _plan(bench_file: BenchFile, scene: str | None, baud: int | None) -> PioneerPlan:
    plan = plan_of(bench_file)
    if scene is not None:
        plan = replace(plan, scene=scene)
    if baud is not None:
        try:
            plan = replace(plan, settings=replace(plan.settings, host_baud=baud))
        except ValueError as error:
            raise UsageError(str(error), where=f"--baud {baud}") from None
    return plan
