"""Whose turn it is to speak where several doors lead to one line: what one of them says at a time is not torn."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

__all__ = ["Turns"]


class Turns:
    """Has what comes in at one door wait until the wire is free of what came in at another; first come, first served.

    So two programs that speak at the same time come one behind the other, as at one socket, and not byte by byte.
    """

    def __init__(self) -> None:
        self._speaker: object = None
        self._waiting: deque[tuple[object, int, Callable[[], object]]] = deque()

    def take(self, door: object, size_bytes: int, speak: Callable[[], object]) -> None:
        """Have `speak` put something on the wire of a door when it is its turn, now or later."""
        self._waiting.append((door, size_bytes, speak))
        self._go_on()

    def waiting(self, door: object) -> list[int]:
        """Return the size, in bytes, of each thing that waits at a door."""
        return [size for other, size, _ in self._waiting if other is door]

    def forget(self, door: object) -> int:
        """Forget what waits at a door; return how many bytes that were."""
        lost = sum(self.waiting(door))
        self._waiting = deque(item for item in self._waiting if item[0] is not door)
        return lost

    def is_silent(self, door: object) -> None:
        """Learn that the wire of a door is free."""
        if door is self._speaker:
            self._speaker = None
            self._go_on()

    def _go_on(self) -> None:
        while self._waiting and self._speaker in (None, self._waiting[0][0]):
            self._speaker, _, speak = self._waiting.popleft()
            speak()
