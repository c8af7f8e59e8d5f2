"""Which benches have a vehicle interface that a car can be driven through, and where it is shown; nothing heavy."""

from __future__ import annotations

from hilbench.bench_file import BenchFile
from targets.robots.vehicle_interface import SIMULATOR_LINE, STACK_LINE

__all__ = ["TRACK", "on_board", "track_for"]

TRACK = "test-track"


def on_board(bench_file: BenchFile) -> bool:
    """Say whether a board of a bench has both lines of a vehicle interface, and a car stands in its world."""
    far_ends = {far.rpartition(".")[2] for name, far in bench_file.checker_lines.items() if name}
    is_car = bench_file.has_world and bench_file.world.vehicle == "car"
    return bool(bench_file.boards) and is_car and {SIMULATOR_LINE, STACK_LINE} <= far_ends


def track_for(bench_file: BenchFile) -> str | None:
    """Return the scene that a bench is shown in where nobody names one: the test track, for a car on an empty floor."""
    return TRACK if on_board(bench_file) and bench_file.world.scene == "empty" else None
