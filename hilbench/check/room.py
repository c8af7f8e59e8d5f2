"""Room for the frames of calls, all in one piece.

CPython keeps the frames of Python functions in chunks of 16 KB. Where a loop calls a function at the very end of a
chunk, each call asks the kernel for another one and each return gives it back, which costs 200 times what the call
does. Below pytest's own forty frames a bench comes to such a place sooner or later, and is slow for no visible reason.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

__all__ = ["with_room"]

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

_SLOTS = 66_000  # of 8 bytes; for a frame so large CPython takes a chunk of 1 MB, and half of it is left over


def with_room(function: Callable[Arguments, Result], *args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
    """Call a function whose own calls, hundreds deep, all have their frames in the same chunk."""
    return function(*args, **kwargs)


with_room.__code__ = with_room.__code__.replace(co_stacksize=_SLOTS)
