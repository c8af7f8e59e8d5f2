"""What the header of a journal says for those who show it: protocol, state machines, boards, the world."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from enum import Enum
from pathlib import Path
from typing import Any

from hilbench.bench.state_reporter import Observed, describe_machine
from hilbench.benchfile.bench_file import EmulatedBoard
from hilbench.plugins.discovery import PLUGINS
from worlds.world import World, engine_of

__all__ = ["about_boards", "about_line", "about_reading", "about_world"]


def about_line(operator: str, protocol: str, machines: Mapping[str, Observed]) -> dict[str, Any]:
    """Return which source of the journal speaks which protocol, and the tables of the state machines to be seen."""
    return {
        "operator": operator,
        "protocol": protocol,
        "machines": {name: describe_machine(observed) for name, observed in machines.items()},
    }


def about_reading(options: Any) -> dict[str, object]:
    """Return how frames are read, a protocol's record of options, as `ProtocolPlugin.options_in` finds it."""
    return {one.name: _plain(getattr(options, one.name)) for one in dataclasses.fields(options)}


def about_world(world: World | None) -> dict[str, Any]:
    """Return what stands there, seen from above, in metres."""
    if world is None:
        return {}
    boxes = [[[round(x, 3), round(y, 3)] for x, y in outline] for outline in world.scene.outlines_m().values()]
    start, name = world.scene.start, world.vehicle.name
    size = {"vehicle_size_m": PLUGINS.systems.vehicle(name).size_m} if name in PLUGINS.systems.vehicle_names() else {}
    return {
        "scene": {"name": world.scene.name, "boxes": boxes, "start": [start.x_m, start.y_m, start.yaw_rad]},
        "vehicle": name,
        **size,
        "physics": world.name,
        "engine": engine_of(world.name),
    }


def about_boards(boards: Mapping[str, EmulatedBoard]) -> dict[str, Any]:
    """Return what is on emulated boards for people to see."""
    return {
        name: {"board": emulated.board_name, "leds": {led.pin: led.name for led in emulated.board.leds}}
        for name, emulated in boards.items()
    }


def _plain(value: object) -> object:
    return value.name if isinstance(value, Enum) else str(value) if isinstance(value, Path) else value
