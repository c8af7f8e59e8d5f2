"""Finds the files of suites: the shipped ones by name, a user's own by path.

A shipped suite is a file, or a folder of files where it is too long for one; ``ORDER`` in the folder's package names
these files as they are to run, and what it does not name follows by its name. A name that begins with ``_`` is of no
case: what several suites, or several files of one, have in common.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

from hilbench.errors import UsageError
from hilbench.files.names import escaped
from hilbench.nearest import did_you_mean

SHIPPED_FOLDER = Path(__file__).parent.parent / "suites"
_PACKAGE = "hilbench.suites"


def shipped_suites(folder: Path = SHIPPED_FOLDER) -> dict[str, Path]:
    """Return the suites that come with hilbench, name to file or folder, in order of their names."""
    found = [path for path in folder.glob("[!_.]*") if path.suffix == ".py" or path.is_dir()]
    return {suite_name(path): path for path in sorted(found, key=lambda path: path.stem)}


def suite_name(path: Path) -> str:
    """Return the name of the suite in a file: ``test_lamp.py`` holds ``lamp``, ``two_lamps.py`` ``two-lamps``.

    A file in the folder of a shipped suite belongs to the suite that the folder is named like.
    """
    own = path.parent if path.parent.parent == SHIPPED_FOLDER else path
    return escaped(own.stem.removeprefix("test_").replace("_", "-"))


def is_shipped(path: Path) -> bool:
    """Say whether a file or folder belongs to a suite that comes with hilbench."""
    return SHIPPED_FOLDER in path.parents


def find_suites(wanted: Sequence[str]) -> list[Path]:
    """Return the files of the wanted suites (a user's own folder as it is), each once, in the order asked for.

    Args:
        wanted: names of shipped suites and paths; empty for all shipped suites.

    Raises:
        UsageError: there is no such suite.
    """
    shipped = shipped_suites()
    found = [_find(name, shipped) for name in wanted] or list(shipped.values())
    return list(dict.fromkeys(file for path in found for file in _files_of(path)))


def _files_of(path: Path) -> list[Path]:
    if not (is_shipped(path) and path.is_dir()):
        return [path]
    order: Sequence[str] = getattr(import_module(f"{_PACKAGE}.{path.name}"), "ORDER", ())
    places = {name: place for place, name in enumerate(order)}
    return sorted(path.glob("[!_]*.py"), key=lambda file: (places.get(file.stem, len(places)), file.stem))


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
