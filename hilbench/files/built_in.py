"""The benches that come with hilbench, each in the folder of its system: found without importing that."""

from __future__ import annotations

from pathlib import Path

__all__ = ["built_in_benches"]

_SYSTEMS = Path(__file__).parent.parent / "systems"


def built_in_benches() -> dict[str, Path]:
    """Return their files by their names, in the order of these."""
    return dict(sorted((file.stem, file) for file in _SYSTEMS.glob("*/benches/*.toml")))
