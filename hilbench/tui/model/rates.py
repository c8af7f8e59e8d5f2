"""How fast a number that is counted grows, in bench time."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import deque

__all__ = ["Counted"]

NS_PER_S = 1_000_000_000
_WINDOW_NS = 2 * NS_PER_S
"""Long enough for what comes ten times a second, short enough to be seen to change (choice)."""


class Counted:
    """A counter, and its rate over the last two seconds of bench time."""

    __slots__ = ("_points", "value")

    def __init__(self) -> None:
        self.value = 0
        self._points: deque[tuple[int, int]] = deque()

    def take(self, value: int, ns: int) -> None:
        """Take its value at a bench time; one that has gone down was begun anew."""
        if value < self.value:
            self._points.clear()
        self.value = value
        self._points.append((ns, value))
        while len(self._points) > 2 and self._points[1][0] <= ns - _WINDOW_NS:
            self._points.popleft()

    def per_s(self, now_ns: int) -> float:
        """Return how much it has grown by in a second, lately."""
        start_ns = now_ns - _WINDOW_NS
        at = bisect_right(self._points, (start_ns, math.inf))
        if at:
            return (self.value - self._points[at - 1][1]) * NS_PER_S / _WINDOW_NS
        if not self._points or now_ns <= self._points[0][0]:
            return 0.0
        first_ns, first = self._points[0]
        return (self.value - first) * NS_PER_S / (now_ns - first_ns)
