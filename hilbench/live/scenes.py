"""In which scene a bench is shown; nothing heavy."""

from __future__ import annotations

from hilbench.benchfile.bench_file import BenchFile
from hilbench.plugins.blame import checked
from hilbench.plugins.discovery import PLUGINS

__all__ = ["scene_for"]


def scene_for(bench_file: BenchFile) -> str | None:
    """Return the scene that a bench is shown in where nobody names one; None for that of its file."""
    asked = (checked(system.scene, str, or_none=True) for system in PLUGINS.systems.there())
    return next(filter(None, (scene(bench_file) for scene in asked)), None)
