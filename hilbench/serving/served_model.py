"""The model of a bench file, as something that can be served."""

from __future__ import annotations

from hilbench.bench.served_targets import ServedTarget
from hilbench.benchfile.bench_file import BenchFile
from hilbench.errors import UsageError
from hilbench.plugins.blame import checked
from hilbench.protocol_bench.system import system_of

__all__ = ["served_target"]


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
        UsageError: no target of this bench has a world, or the rate is none that the model knows.
    """
    model = bench_file.model
    assert model is not None
    if scene is not None and not model.kind.has_body:
        raise UsageError("no target of this bench has a world", where=f"--scene {scene}")
    return checked(system_of(model).served, ServedTarget)(bench_file, scene=scene, baud=baud, seed=seed)
