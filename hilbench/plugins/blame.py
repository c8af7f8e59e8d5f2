"""Whose an error is that nobody foresaw: that of code which a user brought, or ours."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from pathlib import Path

from hilbench.errors import UsageError

__all__ = ["place_of"]


def place_of(error: BaseException, is_users: Callable[[Path], bool]) -> str:
    """Return file and line of a user's code where an error is its own; empty where it may be ours.

    It is the user's where it is raised there, and where it says that something of ours was called wrongly.

    Args:
        error: as it was raised.
        is_users: says of a file whether a user brought it.
    """
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if is_users(Path(frame.filename))]
    if not own or not (own[-1] is frames[-1] or isinstance(error, UsageError | TypeError | ValueError)):
        return ""
    return f"{Path(own[-1].filename).name}:{own[-1].lineno}"
