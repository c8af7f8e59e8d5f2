"""How fast a path can be driven: slow enough in its curves, and in time before them.

At each place the speed is at most what keeps the lateral acceleration `v^2 * |curvature|` below its limit. Going back
along the path each place is then slowed down to where braking still reaches the next one, going forward to where
accelerating has come: `v^2 = u^2 + 2 a s`. An open path is driven from any speed and ends at rest.
"""

from __future__ import annotations

import math

from targets.robots.driving_stack.path import Path
from targets.robots.driving_stack.settings import DriverSettings

__all__ = ["SpeedProfile"]

STEP_M = 0.5
"""How far apart the places are at which the speed is worked out; between them it is interpolated (choice)."""


class SpeedProfile:
    """The speeds along a path.

    Args:
        path: the path.
        settings: the limits.
    """

    def __init__(self, path: Path, settings: DriverSettings) -> None:
        self._path = path
        count = max(2, math.ceil(path.length_m / STEP_M))
        self._step_m = path.length_m / count
        places = count if path.closed else count + 1
        self._m_s = [_curve_speed(path, index * self._step_m, settings) for index in range(places)]
        if not path.closed:
            self._m_s[-1] = 0.0
        self._brake(settings.decel_m_s2)
        if path.closed:
            self._gain(settings.accel_m_s2)

    @property
    def least_m_s(self) -> float:
        """The lowest speed of all."""
        return min(self._m_s)

    def speed_m_s(self, s_m: float) -> float:
        """The speed so far along."""
        at = self._path.normal(s_m) / self._step_m
        index = math.floor(at)
        one, other = self._at(index), self._at(index + 1)
        return one + (at - index) * (other - one)

    def _at(self, index: int) -> float:
        return self._m_s[index % len(self._m_s) if self._path.closed else min(index, len(self._m_s) - 1)]

    def _brake(self, decel_m_s2: float) -> None:
        """Slows down before what is slower; twice around a closed path, for the end reaches over the beginning."""
        for index in reversed(range(2 * len(self._m_s) if self._path.closed else len(self._m_s) - 1)):
            here = index % len(self._m_s)
            self._m_s[here] = min(self._m_s[here], self._reached(self._at(index + 1), decel_m_s2))

    def _gain(self, accel_m_s2: float) -> None:
        for index in range(1, 2 * len(self._m_s)):
            here = index % len(self._m_s)
            self._m_s[here] = min(self._m_s[here], self._reached(self._at(index - 1), accel_m_s2))

    def _reached(self, speed_m_s: float, accel_m_s2: float) -> float:
        return math.sqrt(speed_m_s**2 + 2 * accel_m_s2 * self._step_m)


def _curve_speed(path: Path, s_m: float, settings: DriverSettings) -> float:
    curvature = abs(path.curvature_per_m(s_m))
    return min(settings.speed_m_s, math.sqrt(settings.lateral_m_s2 / curvature) if curvature else math.inf)
