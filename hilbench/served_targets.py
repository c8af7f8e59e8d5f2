"""Virtual targets that are no emulated boards, as something that can be put at the end of a line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from hilbench.bench import Bench
from hilbench.bench_file import BenchFile
from hilbench.errors import UsageError
from hilbench.links import Port

__all__ = ["HOST_LINE", "ServedTarget", "served_target"]

HOST_LINE = "host"
"""The line of a target that has one alone."""


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
    model = bench_file.model
    assert model is not None
    if scene is not None and not model.kind.has_body:
        raise UsageError("nothing stands in a world here", where=f"--scene {scene}")
    return model.system.served(bench_file, scene=scene, baud=baud, seed=seed)
