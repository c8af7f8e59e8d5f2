"""The errors of a position and a velocity: one that wanders slowly, and noise on top of it.

The slow error of each axis is a Gauss-Markov process: from one solution to the next, dt later, it keeps exp(-dt / T)
of itself and gets as much new as keeps its variance (choice; the data sheet has the size only). Half of the
horizontal errors are within the circular error probable, so each axis has a standard deviation of CEP / 1.1774.
"""

from __future__ import annotations

import math

from targets.parts.neo6m.geodesy import Vector
from targets.parts.neo6m.settings import Neo6mSettings
from targets.parts.noise import gaussians

__all__ = ["MEDIAN", "Wander"]

MEDIAN = math.sqrt(2 * math.log(2))
"""Half of the lengths of a vector of two normal parts are within so many standard deviations: 1.1774."""


class Wander:
    """See the module.

    Args:
        settings: sizes and times.
        seed: of what is drawn.
    """

    def __init__(self, settings: Neo6mSettings, seed: int) -> None:
        self._settings = settings
        self._seed = seed
        self._count = 0
        self._last_ns: int | None = None
        self._unit = (0.0, 0.0, 0.0)
        self.noise_m = self.velocity_m_s = (0.0, 0.0, 0.0)

    def step(self, now_ns: int) -> None:
        """Go on to the next solution."""
        drawn = gaussians(self._seed, "wander", self._count)
        other = gaussians(self._seed, "speed", self._count)
        self._count += 1
        kept = 0.0
        if self._last_ns is not None:
            kept = math.exp(-(now_ns - self._last_ns) / 1e9 / self._settings.correlation_s)
        new = math.sqrt(1 - kept**2)
        self._last_ns = now_ns
        x, y, z = (kept * old + new * part for old, part in zip(self._unit, drawn[:3], strict=True))
        self._unit = x, y, z
        noise, speed = self._settings.noise_m, self._settings.velocity_m_s / MEDIAN
        self.noise_m = drawn[3] * noise, drawn[4] * noise, drawn[5] * noise
        self.velocity_m_s = other[0] * speed, other[1] * speed, other[2] * speed

    def position_m(self, east_m: float, north_m: float, up_m: float) -> Vector:
        """Return the error to the east, to the north and up, for standard deviations of its slow part."""
        e, n, u = self._unit
        a, b, c = self.noise_m
        return e * east_m + a, n * north_m + b, u * up_m + c
