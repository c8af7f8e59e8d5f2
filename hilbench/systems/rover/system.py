"""The rover as a system: its controller as a model, its body on four wheels, and what checks, drives and serves it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from hilbench.plugins.protocol import ClauseEntry
from hilbench.plugins.system import API, HandRequest, ModelKind, System, VehicleKind

if TYPE_CHECKING:
    from hilbench.bench import Bench
    from hilbench.bench.served_targets import ServedTarget
    from hilbench.bench.shared import Shared
    from hilbench.benchfile.bench_file import BenchFile
    from hilbench.driving.rig import Rig
    from hilbench.judging.provider import BenchProvider
    from hilbench.links import Port
    from hilbench.mcu.emulated import EmulatedBench
    from hilbench.plugins.dashboard import Dashboard
    from hilbench.plugins.demo import Demo
    from hilbench.terminal.options import TargetChoice

__all__ = ["ROVER", "ROVER_ROOM"]

TARGET = "rover-model"
VEHICLE = "rover-4wd"
ROVER_ROOM = "rover-room"


def _four_wheels() -> VehicleKind:
    from hilbench.systems.rover.signals import ROVER_SIGNALS, RoverSignals
    from worlds.vehicles import rover_4wd

    return VehicleKind(
        vehicle=rover_4wd.vehicle,
        body=rover_4wd.Rover4wdBody,
        signals=ROVER_SIGNALS,
        wire=RoverSignals,
        size_m=(0.26, 0.16),
    )


_REQUESTS = {
    "led": HandRequest(text="is the test LED lit?", capability="led", answers=("lit", "dark")),
    "hold-wheels": HandRequest(
        text="hold all four wheels, so that none turns", capability="wheels", undo="release-wheels"
    ),
    "release-wheels": HandRequest(text="let go of the wheels", capability="wheels"),
    "hold-reset": HandRequest(
        text="press the board's reset button and keep it pressed", capability="boot", undo="release-reset"
    ),
    "release-reset": HandRequest(text="let go of the reset button", capability="boot"),
    "face-north": HandRequest(
        text="put the rover on level ground, its front towards magnetic north, and let it rest", capability="imu"
    ),
    "turn": HandRequest(
        text="turn the rover slowly to and fro {}, some 75 degrees to either side, 8 s for there and back, and go on",
        capability="turned",
        undo="put-down",
    ),
    "put-down": HandRequest(text="put the rover down on its wheels", capability="turned"),
    "position": HandRequest(
        text="is the rover within 100 m of latitude {}, longitude {}, north and east positive?",
        capability="gps",
        answers=("yes", "no"),
    ),
    "carry": HandRequest(
        text="carry the rover at least 200 m away, or feign that to its receiver; wait for its fix",
        capability="carried",
    ),
    "cover-sky": HandRequest(
        text="cover the GPS receiver, or unplug its antenna, until it has no fix: its light does not blink",
        capability="sky",
        undo="uncover-sky",
    ),
    "uncover-sky": HandRequest(
        text="give the GPS receiver its view of the sky, and wait for its fix: its light blinks", capability="sky"
    ),
    "air": HandRequest(
        text="is the air around the rover between {} and {} degrees Celsius?", capability="air", answers=("yes", "no")
    ),
}


class Rover(System):
    """See the module."""

    api = API
    name = "rover"
    title = "Rover"
    summary = "a rover on four wheels behind its PKT! line"
    vehicles = MappingProxyType({VEHICLE: _four_wheels})
    speakers = MappingProxyType({"rover": "target"})
    checkers = MappingProxyType({"rover": "host"})
    hand_requests = MappingProxyType(_REQUESTS)

    def models(self) -> Mapping[str, ModelKind]:
        """See `System`."""
        from targets.robots.pioneer.hostbaud import RATES
        from targets.robots.rover import RoverSettings

        rover = ModelKind(
            settings=RoverSettings,
            protocol="PKT!",
            suites=("pkt-board", "pkt-host"),
            rates=tuple(RATES),
            bench="rover-model",
            target=TARGET,
        )
        return {"rover": rover}

    def clauses(self) -> Sequence[ClauseEntry]:
        """See `System`."""
        from hilbench.systems.rover.motion_clauses import CLAUSES

        return CLAUSES

    def provider(self, shared: Shared, choices: Sequence[TargetChoice]) -> BenchProvider:
        """See `System`."""
        from hilbench.bench.target_choice import client_provider, only_choice
        from hilbench.benchfile.target_grammar import TargetKind, target_of
        from hilbench.systems.rover.provider import AttachedRoverProvider, RoverProvider, foreign_host

        if not choices:
            return RoverProvider(shared)
        choice = only_choice(shared, choices)
        target = target_of(choice)
        if target.kind is TargetKind.MODEL and target.text == TARGET:
            return RoverProvider(shared)
        if target.kind is TargetKind.SERIAL:
            return AttachedRoverProvider(shared, target.text)
        return client_provider(shared, choice, foreign_host(shared), TARGET)

    def board_provider(self, shared: Shared, choices: Sequence[TargetChoice]) -> BenchProvider | None:
        """See `System`."""
        from hilbench.bench.target_choice import port_of_boards
        from hilbench.systems.rover.provider import AttachedRoverProvider

        choice = port_of_boards(shared, choices)
        return None if choice is None else AttachedRoverProvider(shared, choice.spec)

    def board_capabilities(self, bench_file: BenchFile) -> Iterable[str]:
        """See `System`."""
        from hilbench.systems.rover.hands import hands_on

        return hands_on(bench_file)

    def about_board(self, bench_file: BenchFile, program: str) -> Mapping[str, Any]:
        """See `System`."""
        from hilbench.systems.rover.about import about_pkt
        from protocols.pkt import PROFILES

        del bench_file
        return about_pkt("checker", {}, program if program in PROFILES else "documented")

    def served(self, bench_file: BenchFile, *, scene: str | None, baud: int | None, seed: int) -> ServedTarget:
        """See `System`."""
        from hilbench.bench.devices import DeviceActor
        from hilbench.bench.served_targets import HOST_LINE, ServedTarget
        from hilbench.systems.rover.cases import rover_baud
        from targets.robots.rover import RoverRobot, RoverSettings

        del scene, seed
        settings = bench_file.settings_of(RoverSettings)
        assert settings is not None

        def make(bench: Bench, ports: Mapping[str, Port]) -> Callable[[], None]:
            DeviceActor(bench, RoverRobot(settings), ports[HOST_LINE], name="rover")
            return lambda: None

        return ServedTarget({HOST_LINE: baud or rover_baud(bench_file)}, make, "rover")

    def rig(self, bench: Bench, bench_file: BenchFile, *, seed: int) -> Rig:
        """See `System`."""
        from hilbench.systems.rover.rig import model_rig

        return model_rig(bench, bench_file, seed)

    def board_rig(self, emulated: EmulatedBench, *, seed: int) -> Rig | None:
        """See `System`."""
        from hilbench.systems.rover.rig import board_rig

        there = emulated.bench_file.checker_lines.get("", "") in emulated.ports
        return board_rig(emulated, seed) if there and "pkt-board" in emulated.bench_file.suites else None

    def attached_rig(self, bench: Bench, bench_file: BenchFile, ports: Mapping[str, str], *, seed: int) -> Rig:
        """See `System`."""
        from hilbench.systems.rover.rig import attached_rig

        return attached_rig(bench, bench_file, ports[""], seed)

    def scene(self, bench_file: BenchFile) -> str | None:
        """Give the rover that comes with hilbench a floor: for its checks it stands on a stand.

        A stand in a file of one's own was named by somebody.
        """
        is_ours = bench_file.path is not None and bench_file.path.parent == Path(__file__).with_name("benches")
        on_stand = (bench_file.world.vehicle, bench_file.world.scene) == (VEHICLE, "stand")
        return ROVER_ROOM if is_ours and bench_file.has_world and on_stand else None

    def dashboard(self) -> Dashboard:
        """See `System`."""
        from hilbench.systems.rover.dashboard import DASHBOARD

        return DASHBOARD

    def demo(self, *, physics: bool) -> Demo:
        """See `System`."""
        from hilbench.systems.rover.script import rover_demo

        return rover_demo(physics=physics)


ROVER = Rover()
