"""Imports a library in C to its end, whatever signal comes meanwhile.

An exception that a signal's handler raises in the middle is lost there: the C API of NumPy makes an ImportError of it,
"numpy.core.multiarray failed to import", and the library then counts as one that is not installed.
"""

from __future__ import annotations

import contextlib
import importlib
import signal
from collections.abc import Iterator
from types import FrameType
from typing import Any

__all__ = ["import_whole"]

_ENDINGS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def import_whole(name: str) -> Any:
    """Return the module of that name; a signal that came while it was imported is handled then.

    Raises:
        ImportError: it cannot be imported.
    """
    with _held_back():
        return importlib.import_module(name)


@contextlib.contextmanager
def _held_back() -> Iterator[None]:
    came: list[int] = []

    def note(number: int, _frame: FrameType | None) -> None:
        came.append(number)

    handlers = {number: signal.getsignal(number) for number in _ENDINGS}
    ours = [number for number, handler in handlers.items() if callable(handler)]
    try:
        for number in ours:
            signal.signal(number, note)
    except ValueError:  # not in the main thread, which alone handles signals
        yield
        return
    try:
        yield
    finally:
        for number in ours:
            signal.signal(number, handlers[number])
        for one in came:
            signal.raise_signal(one)
