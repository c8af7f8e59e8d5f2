"""Paths from the root, also where there is no working folder any more."""

from __future__ import annotations

import os
from pathlib import Path

from hilbench.errors import UnavailableError

__all__ = ["absolute_path", "real_path"]


def absolute_path(path: str | Path) -> Path:
    """Return a path from the root; links in it stay.

    Raises:
        UnavailableError: it begins in the working folder, and that has been removed.
    """
    try:
        return Path(path).absolute()
    except FileNotFoundError:
        hint = "write the path from the root, or go to another folder"
        raise UnavailableError("the working folder has been removed", where=str(path), hint=hint) from None


def real_path(path: str | Path) -> str:
    """Return where a path leads, from the root and without links.

    Raises:
        UnavailableError: as `absolute_path`.
    """
    return os.path.realpath(absolute_path(path))
