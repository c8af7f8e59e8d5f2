"""How far a long job is, and how long it will still take."""

from __future__ import annotations

import threading
import time


class Pace:
    """Counts what is done.

    Args:
        count: how much there is.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._done = 0
        self._began_s = time.monotonic()
        self._lock = threading.Lock()

    def one_more(self) -> str:
        """Return how far it is, now that one more is done."""
        with self._lock:
            self._done += 1
            left_s = (time.monotonic() - self._began_s) / self._done * (self._count - self._done)
            return f"{self._done} of {self._count}, {left_s / 60:.0f} min to go:"
