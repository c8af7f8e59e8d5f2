"""Says in a log what runs, while nothing else is said: a log that stands still looks like a run that hangs."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import TracebackType
from typing import Self

__all__ = ["EVERY_S", "Heartbeat"]

EVERY_S = 10.0
"""How long a log may stand still (choice; CI systems end jobs whose log does so for minutes)."""


class Heartbeat:
    """See the module; a context, within which it says something.

    Args:
        say: called with a line, in a thread of its own.
        every_s: how long to wait for others to say something, in seconds.
    """

    def __init__(self, say: Callable[[str], None], every_s: float = EVERY_S) -> None:
        self._say = say
        self._every_s = every_s
        self._text = ""
        self._spoken = False
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._beat, daemon=True)

    def show(self, text: str) -> None:
        """Take what runs now."""
        self._text = text

    def spoke(self) -> None:
        """Take note that something was said."""
        self._spoken = True

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._over.set()
        self._thread.join()

    def _beat(self) -> None:
        while not self._over.wait(self._every_s):
            if self._text and not self._spoken:
                self._say(f"running {self._text}")
            self._spoken = False
