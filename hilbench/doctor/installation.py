"""What is installed here: versions, boards, chips, benches, suites."""

from __future__ import annotations

import importlib.metadata
import platform
from pathlib import Path

import hilbench

__all__ = ["as_data", "as_text"]

_PARTS = ("pybullet", "mujoco-core", "pytest")
"""What decides how a run goes beside ours: the physics, the engine of suites."""


def as_data() -> dict[str, object]:
    """Return it as plain data."""
    from hilbench.benchfile.suites import shipped_suites
    from hilbench.files.built_in import built_in_benches
    from targets.boards import board_names
    from targets.mcu.variants import VARIANTS

    return {
        "hilbench": hilbench.__version__,
        "folder": str(Path(hilbench.__file__).parent),
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "parts": {part: _version(part) for part in _PARTS},
        "boards": list(board_names()),
        "chips": list(VARIANTS),
        "benches": list(built_in_benches()),
        "suites": list(shipped_suites()),
    }


def as_text() -> str:
    """Return it as lines for a person."""
    data = as_data()
    parts = data.pop("parts")
    assert isinstance(parts, dict)
    rows = data | {part: version or "not installed" for part, version in parts.items()}
    order = ("hilbench", "folder", "python", "platform", *parts, "boards", "chips", "benches", "suites")
    width = max(map(len, order))
    return "\n".join(f"{name:<{width}}  {_joined(rows[name])}" for name in order)


def _joined(value: object) -> str:
    return ", ".join(value) if isinstance(value, list) else str(value)


def _version(distribution: str) -> str | None:
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return None
