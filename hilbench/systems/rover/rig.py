"""A rover on a live bench, and our ground station at its line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hilbench.bench import Bench
from hilbench.bench.devices import DeviceActor
from hilbench.bench.state_reporter import Observed
from hilbench.benchfile.bench_file import BenchFile
from hilbench.driving.real_port import open_at
from hilbench.driving.resuming import resume_sessions
from hilbench.driving.rig import CLIENT_SENSES, Rig
from hilbench.driving.tap import Tap
from hilbench.links import Line, MemoryLink, Port
from hilbench.links.memory import REAL_TIME_GROUP_NS
from hilbench.mcu.emulated import EmulatedBench
from hilbench.systems.rover.about import about_pkt
from hilbench.systems.rover.cases import rover_baud
from hilbench.systems.rover.ground_station import GroundStation
from hilbench.systems.rover.operator import RoverOperator
from hilbench.systems.rover.provider import AttachedRoverProvider
from protocols.pkt import PROFILES
from targets.robots.rover import RoverRobot, RoverSettings

__all__ = ["attached_rig", "board_rig", "model_rig"]

_OF_BOARDS = "documented"
"""The profile that boards are spoken to in."""


def model_rig(bench: Bench, bench_file: BenchFile, seed: int) -> Rig:
    """Build the behavioural rover of a bench file."""
    settings = bench_file.settings_of(RoverSettings)
    assert settings is not None
    link = MemoryLink(bench.scheduler, Line(baud=rover_baud(bench_file)), name="host", group_ns=REAL_TIME_GROUP_NS)
    robot = RoverRobot(settings)
    DeviceActor(bench, robot, link.b, name="rover")
    tap, operator = _station(bench, link.a, settings.profile, seed)
    return _rig(tap, operator, settings.profile, {"rover": robot.connection})


def board_rig(emulated: EmulatedBench, seed: int) -> Rig:
    """Put the ground station to the line of an emulated board."""
    port = emulated.far_ends.reacting(emulated.bench_file.checker_lines[""])
    return _rig(*_station(emulated.bench, port, _OF_BOARDS, seed), _OF_BOARDS)


def attached_rig(bench: Bench, bench_file: BenchFile, target: str, seed: int) -> Rig:
    """Attach to a rover at a port."""
    port = open_at(bench, bench_file, target, AttachedRoverProvider.USUAL_BAUD)
    settings = bench_file.settings_of(RoverSettings)
    profile = _OF_BOARDS if settings is None else settings.profile
    tap, operator = _station(bench, port, profile, seed)
    resume_sessions(tap, operator)
    return _rig(tap, operator, profile, demo=False, close=port.close)


def _rig(
    tap: Tap, operator: RoverOperator, profile: str, rover: Mapping[str, Observed] | None = None, **more: Any
) -> Rig:
    machines = {operator.name: operator.observed, **(rover or {})}
    return Rig(
        operator=operator,
        taps={"host": tap},
        machines=machines,
        senses={operator.name: CLIENT_SENSES},
        about=about_pkt(operator.name, machines, profile),
        **more,
    )


def _station(bench: Bench, port: Port, profile: str, seed: int) -> tuple[Tap, RoverOperator]:
    tap = Tap(bench, port, "station", seed=seed)
    return tap, RoverOperator(bench, GroundStation(bench, tap, PROFILES[profile]))
