"""What the header of a journal says for those who show it: protocol, state machines, boards, the world."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hilbench.bench_file import EmulatedBoard
from hilbench.live.teller import Observed, describe_machine
from worlds.world import World

__all__ = ["about_boards", "about_line", "about_pkt", "about_sonars", "about_vehicle_lines", "about_world"]


def about_line(operator: str, protocol: str, machines: Mapping[str, Observed]) -> dict[str, Any]:
    """Return which source of the journal speaks which protocol, and the tables of the state machines to be seen."""
    return {
        "operator": operator,
        "protocol": protocol,
        "machines": {name: describe_machine(observed) for name, observed in machines.items()},
    }


def about_pkt(operator: str, machines: Mapping[str, Observed], profile: str) -> dict[str, Any]:
    """Return what `about_line` does of PKT!, and how its frames are made in a profile."""
    from protocols.pkt import PROFILES

    server = PROFILES[profile].server
    about = about_line(operator, "pkt", machines)
    return about | {"framing": server.frames.framing.name, "schema": server.schema.name, "profile": profile}


def about_vehicle_lines(lines: Mapping[str, str]) -> dict[str, Any]:
    """Return which sources speak what at a vehicle interface.

    Args:
        lines: the board's end of each line, by its source in the journal.
    """
    from targets.robots.vehicle_interface import SIMULATOR_LINE, STACK_LINE

    spoken = {SIMULATOR_LINE: ("carla", "simulator"), STACK_LINE: ("autoware", "stack")}
    ends = {source: spoken[end] for source, end in lines.items() if end in spoken}
    return {"speakers": {source: {"protocol": protocol, "line": line} for source, (protocol, line) in ends.items()}}


def about_sonars(subclass: str) -> dict[str, Any]:
    """Return where the discs sit, what a raw range means, and from which on nothing was heard."""
    from hilbench.pioneer.robot import sonar_poses
    from protocols.p2os import robot_parameters
    from protocols.p2os.units import NO_ECHO_RAW

    poses = [[round(x_m, 4), round(y_m, 4), round(th_rad, 4)] for x_m, y_m, th_rad in sonar_poses(subclass)]
    unit_mm = robot_parameters(subclass).range_unit_mm
    return {"sonars": poses, "sonar_unit_mm": unit_mm, "sonar_no_echo": NO_ECHO_RAW}


def about_world(world: World | None) -> dict[str, Any]:
    """Return what stands there, seen from above, in metres."""
    if world is None:
        return {}
    boxes = [[[round(x, 3), round(y, 3)] for x, y in outline] for outline in world.scene.outlines_m().values()]
    start = world.scene.start
    return {
        "scene": {"name": world.scene.name, "boxes": boxes, "start": [start.x_m, start.y_m, start.yaw_rad]},
        "vehicle": world.vehicle.name,
        "physics": world.name,
    }


def about_boards(boards: Mapping[str, EmulatedBoard]) -> dict[str, Any]:
    """Return what is on emulated boards for people to see."""
    return {
        name: {"board": emulated.board_name, "leds": {led.pin: led.name for led in emulated.board.leds}}
        for name, emulated in boards.items()
    }
