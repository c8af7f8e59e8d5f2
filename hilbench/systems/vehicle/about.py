"""What the header of a journal says of a vehicle interface for those who show it; see `hilbench.bench.about`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["about_vehicle_lines"]


def about_vehicle_lines(lines: Mapping[str, str]) -> dict[str, Any]:
    """Return which sources speak what at a vehicle interface.

    Args:
        lines: the board's end of each line, by its source in the journal.
    """
    from targets.robots.vehicle_interface import SIMULATOR_LINE, STACK_LINE

    spoken = {SIMULATOR_LINE: ("carla", "simulator"), STACK_LINE: ("autoware", "stack")}
    ends = {source: spoken[end] for source, end in lines.items() if end in spoken}
    return {"speakers": {source: {"protocol": protocol, "line": line} for source, (protocol, line) in ends.items()}}
