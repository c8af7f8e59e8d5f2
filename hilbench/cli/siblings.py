"""Are `protocols`, `targets` and `worlds` our own?

The names are plain English, so a user's folder or another distribution may hold the same ones, and the first on
``sys.path`` wins. Ours stand in the folder in which `hilbench` itself stands; anything else is an intruder.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Sequence
from pathlib import Path

import hilbench
from hilbench.errors import UnavailableError

SIBLINGS = ("protocols", "targets", "worlds")


def check_siblings() -> None:
    """Make sure that the packages next to hilbench are those that will be imported.

    Raises:
        UnavailableError: another package takes the place of one of them; its path is named.
    """
    home = Path(hilbench.__file__).resolve().parent.parent
    for name in SIBLINGS:
        found = _folders(name)
        if home / name not in found:
            raise _intruder(name, found, home)


def leave_working_folder() -> None:
    """Take the working folder off ``sys.path``, where ``python -m hilbench`` put it.

    Then the command behaves like the installed script, which never looks there. If hilbench itself was found there the
    folder stays: it is a checkout. In one that has been removed there is nothing to be imported.
    """
    try:
        here = Path.cwd()
    except FileNotFoundError:
        return
    home = Path(hilbench.__file__).resolve().parent.parent
    if sys.path and not sys.flags.safe_path and Path(sys.path[0] or ".").resolve() == here and here != home:
        del sys.path[0]


def _folders(name: str) -> list[Path]:
    module = sys.modules.get(name)
    try:
        spec = module.__spec__ if module is not None else importlib.util.find_spec(name)
    except (ImportError, ValueError):
        return []
    if spec is None:
        return []
    if spec.submodule_search_locations is None:
        return [Path(spec.origin).resolve()] if spec.origin else []
    return [Path(folder).resolve() for folder in spec.submodule_search_locations]


def _intruder(name: str, found: Sequence[Path], home: Path) -> UnavailableError:
    if not found:
        return UnavailableError(
            f"the package '{name}' is missing",
            where=str(home),
            hint="install hilbench again, best in an environment of its own",
        )
    return UnavailableError(
        f"shadows the package '{name}' of hilbench ({home / name})",
        where=str(found[0]),
        hint="rename it, or take its folder off sys.path and PYTHONPATH",
    )
