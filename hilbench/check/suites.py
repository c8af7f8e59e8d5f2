"""Finds the files of suites: the shipped ones by name, a user's own by path."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hilbench.errors import UsageError
from hilbench.names import escaped
from hilbench.nearest import did_you_mean

SHIPPED_FOLDER = Path(__file__).parent.parent / "suites"


def shipped_suites(folder: Path = SHIPPED_FOLDER) -> dict[str, Path]:
    """Return the suites that come with hilbench, name to file, in order of their names."""
    files = sorted(folder.glob("[!_]*.py"))
    return {suite_name(file): file for file in files}


def suite_name(file: Path) -> str:
    """Return the name of the suite in a file: ``p2os_server.py`` holds ``p2os-server``, ``test_lamp.py`` ``lamp``."""
    return escaped(file.stem.removeprefix("test_").replace("_", "-"))


def find_suites(wanted: Sequence[str]) -> list[Path]:
    """Return the files or folders of the wanted suites, each once, in the order asked for.

    Args:
        wanted: names of shipped suites and paths; empty for all shipped suites.

    Raises:
        UsageError: there is no such suite.
    """
    shipped = shipped_suites()
    if not wanted:
        return list(shipped.values())
    return list(dict.fromkeys(_find(name, shipped) for name in wanted))


def _find(name: str, shipped: dict[str, Path]) -> Path:
    if name in shipped:
        return shipped[name]
    path = Path(name)
    if path.is_dir() or (path.is_file() and path.suffix == ".py"):
        return path.resolve()
    if path.exists():
        raise UsageError("not a .py file or a folder", where=f"--suite {name}")
    raise UsageError(
        "no such suite or file", where=f"--suite {name}", hint=did_you_mean(name, shipped, "shipped suites")
    )
