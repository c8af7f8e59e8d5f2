"""In which scene a bench is shown, and which have a vehicle interface that a car is driven through; nothing heavy."""

from __future__ import annotations

from hilbench.bench_file import BenchFile
from hilbench.config import BUILT_IN_FOLDER
from targets.robots.vehicle_interface import SIMULATOR_LINE, STACK_LINE

__all__ = ["ROVER_ROOM", "TRACK", "on_board", "scene_for"]

TRACK = "test-track"
ROVER_ROOM = "rover-room"


def on_board(bench_file: BenchFile) -> bool:
    """Say whether a board of a bench has both lines of a vehicle interface, and a car stands in its world."""
    far_ends = {far.rpartition(".")[2] for name, far in bench_file.checker_lines.items() if name}
    is_car = bench_file.has_world and bench_file.world.vehicle == "car"
    return bool(bench_file.boards) and is_car and {SIMULATOR_LINE, STACK_LINE} <= far_ends


def scene_for(bench_file: BenchFile) -> str | None:
    """Return the scene that a bench is shown in where nobody names one; None for that of its file.

    A car on an empty floor is shown on the test track. The rover that comes with hilbench stands on a stand, for its
    checks; here it has a floor. A stand in a file of one's own was named by somebody.
    """
    if on_board(bench_file) and bench_file.world.scene == "empty":
        return TRACK
    is_ours = bench_file.path is not None and bench_file.path.parent == BUILT_IN_FOLDER
    if (
        is_ours
        and bench_file.has_world
        and (bench_file.world.vehicle, bench_file.world.scene) == ("rover-4wd", "stand")
    ):
        return ROVER_ROOM
    return None
