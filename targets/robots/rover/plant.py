"""The four wheels, in the air: how fast they turn at which throttle, and when a slot passes a tachometer.

The steady speeds are those of the published bench test with the wheels lifted (nhorro/ceai2020,
intro_se/workspace/rover_groundcontrol, RoverBasicBenchTest.ipynb): nothing moves below a throttle of 0.23, and what
moves goes on down to 0.195. Beyond 0.39 the published tachometers show nothing: the line to full throttle is assumed.
"""

from __future__ import annotations

import math
from bisect import bisect_right

__all__ = ["SLOTS", "STEADY_RPM", "WHEELS", "Plant", "Wheel", "steady_rpm"]

WHEELS = 4
"""Left front, right front, left back, right back: the order of the tachometers."""
SLOTS = 20
"""Slots of a tachometer's disc (G2 config.h; G1 had 32)."""

STEADY_RPM = (
    (0.195, 70.0),
    (0.25, 97.5),
    (0.30, 117.5),
    (0.35, 133.0),
    (0.39, 143.5),
    (1.0, 250.0),
)
"""Throttle and steady speed in rpm, between which lines are drawn; the first and the last are assumed."""

BREAKAWAY = 0.23
"""The throttle at which a standing wheel begins to turn."""
STALLS = 0.195
"""The throttle below which a turning wheel stops."""

_STANDING_RPM = 1.0
_NS_PER_S = 1_000_000_000
_EDGES_KEPT = 2


def steady_rpm(throttle: float, *, turning: bool) -> float:
    """The speed in rpm, with the sign of the throttle, that a wheel comes to; a throttle that is no number is 0."""
    size = 0.0 if math.isnan(throttle) else min(1.0, abs(throttle))
    if size < (STALLS if turning else BREAKAWAY):
        return 0.0
    at = min(bisect_right([point[0] for point in STEADY_RPM], size), len(STEADY_RPM) - 1)
    (low, low_rpm), (high, high_rpm) = STEADY_RPM[at - 1 : at + 1]
    return math.copysign(low_rpm + (size - low) / (high - low) * (high_rpm - low_rpm), throttle)


class Wheel:
    """One wheel with its motor and its disc.

    Attributes:
        rpm: its speed, negative backwards.
        turns: how far it has turned.
        ticks: slots that have passed.
        edge_times_ns: when the last two of them did.
        forced_rpm: the speed that it is turned at by hand, 0 to hold it; None to let it go.
    """

    def __init__(self, lag_s: float) -> None:
        self.rpm = 0.0
        self.turns = 0.0
        self.ticks = 0
        self.edge_times_ns: list[int] = []
        self.forced_rpm: float | None = None
        self._lag_s = lag_s

    def advance(self, throttle: float, from_ns: int, to_ns: int) -> None:
        """Turns under a throttle from one time to another, in ns."""
        duration_s = (to_ns - from_ns) / _NS_PER_S
        before = self.turns
        if self.forced_rpm is not None:
            self.rpm = self.forced_rpm
            self.turns += self.rpm / 60 * duration_s
        else:
            final_rpm = steady_rpm(throttle, turning=abs(self.rpm) > _STANDING_RPM)
            gap_rpm, kept = self.rpm - final_rpm, math.exp(-duration_s / self._lag_s)
            self.rpm = final_rpm + gap_rpm * kept
            self.turns += (final_rpm * duration_s + gap_rpm * self._lag_s * (1 - kept)) / 60
        self._pass_slots(before, from_ns, to_ns)

    def _pass_slots(self, before: float, from_ns: int, to_ns: int) -> None:
        """Counts the slots of this stretch, each at the time at which it passes if the wheel turns evenly."""
        first, last = math.floor(before * SLOTS), math.floor(self.turns * SLOTS)
        edges = range(first + 1, last + 1) if last > first else range(first, last, -1)
        for edge in edges:
            share = (edge / SLOTS - before) / (self.turns - before)
            self.ticks += 1
            self.edge_times_ns = [*self.edge_times_ns, from_ns + round(share * (to_ns - from_ns))][-_EDGES_KEPT:]


class Plant:
    """All four wheels; those of a side share their throttle.

    Args:
        lag_s: the time in which a wheel comes within 37 % of its steady speed.
    """

    def __init__(self, lag_s: float) -> None:
        self.wheels = tuple(Wheel(lag_s) for _ in range(WHEELS))
        self._now_ns = 0

    def advance(self, throttles: tuple[float, float], now_ns: int) -> None:
        """Turns the wheels under the throttles of the left and the right pair, up to a time in ns."""
        for number, wheel in enumerate(self.wheels):
            wheel.advance(throttles[number % 2], self._now_ns, now_ns)
        self._now_ns = now_ns

    def force(self, rpm: float | None) -> None:
        """Turns all wheels at this speed by hand, holds them for 0, lets them go for None."""
        for wheel in self.wheels:
            wheel.forced_rpm = rpm
