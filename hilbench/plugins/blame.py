"""Whose an error is that nobody foresaw: that of code which a user brought, or ours."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from hilbench.errors import PluginError, UsageError
from worlds.errors import WorldError

__all__ = ["checked", "place_of"]

_P = ParamSpec("_P")
_T = TypeVar("_T")


def place_of(error: BaseException, is_users: Callable[[Path], bool]) -> str:
    """Return file and line of a user's code where an error is its own; empty where it may be ours.

    It is the user's where it is raised there, and where it says that something of ours was called wrongly.

    Args:
        error: as it was raised.
        is_users: says of a file whether a user brought it.
    """
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if is_users(Path(frame.filename))]
    if not own or not (own[-1] is frames[-1] or isinstance(error, UsageError | TypeError | ValueError | WorldError)):
        return ""
    return f"{Path(own[-1].filename).name}:{own[-1].lineno}"


def checked(method: Callable[_P, _T], kind: type[Any], *, or_none: bool = False) -> Callable[_P, _T]:
    """Return a method of a plug-in as one whose result is looked at.

    Args:
        method: the method; calling it raises a `PluginError` with its file and line where it returns something else.
        kind: the class of what it returns.
        or_none: it may return None.
    """

    def call(*args: _P.args, **kwargs: _P.kwargs) -> _T:
        made = method(*args, **kwargs)
        if isinstance(made, kind) or (made is None and or_none):
            return made
        code = getattr(method, "__code__", None)
        where = code and f"{Path(code.co_filename).name}:{code.co_firstlineno}"
        name = getattr(method, "__qualname__", repr(method))
        raise PluginError(f"{name}() returns {made!r}, and no {kind.__name__}", where=where)

    return call
