"""What mechanics says of a motion: way and time of a trapezoid, stopping distance, turn radius, the pose on an arc.

Formulas only, of rigid-body kinematics; nothing here knows a robot, a world or a packet. Any unit of length will do, as
long as it is one and the same; angles are degrees where a name says so.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence

Point = tuple[float, float]


def stopping_way(speed: float, deceleration: float) -> float:
    """Return the way from ``speed`` to rest at a constant deceleration: v² / 2a."""
    return speed * speed / (2 * deceleration)


def trapezoid_time_s(way: float, speed: float, acceleration: float) -> float:
    """Return the time from rest to rest over ``way``, with equal ramps, never faster than ``speed``.

    Way and speed are positive. A way too short to reach the speed makes a triangle of twice sqrt(way / a).
    """
    if way * acceleration < speed * speed:
        return 2 * math.sqrt(way / acceleration)
    return way / speed + speed / acceleration


def turn_radius(speed: float, turn_deg_s: float) -> float:
    """Return the radius of the circle on which ``speed`` and a rate of turn go together: v / w."""
    return abs(speed / math.radians(turn_deg_s))


def arc_end(speed: float, turn_deg_s: float, duration_s: float) -> Point:
    """Return where an arc ends that begins at the origin towards +x: how far ahead, and how far to the left."""
    turned_rad = math.radians(turn_deg_s * duration_s)
    radius = speed / math.radians(turn_deg_s)
    return radius * math.sin(turned_rad), radius * (1 - math.cos(turned_rad))


def slope(times_s: Sequence[float], values: Sequence[float]) -> float:
    """Return the rate of change by least squares."""
    return statistics.linear_regression(times_s, values).slope


def circle_radius(points: Sequence[Point]) -> float:
    """Return the radius of the circle through the points, by least squares of x² + y² = 2ax + 2by + c.

    Args:
        points: at least three that are not on a line.
    """
    middle_x, middle_y = statistics.fmean(x for x, _ in points), statistics.fmean(y for _, y in points)
    shifted = [(x - middle_x, y - middle_y) for x, y in points]
    xx, yy = math.fsum(x * x for x, _ in shifted), math.fsum(y * y for _, y in shifted)
    xy = math.fsum(x * y for x, y in shifted)
    xz = math.fsum(x * (x * x + y * y) for x, y in shifted) / 2
    yz = math.fsum(y * (x * x + y * y) for x, y in shifted) / 2
    determinant = xx * yy - xy * xy
    center_x, center_y = (xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant
    return math.sqrt(center_x**2 + center_y**2 + (xx + yy) / len(shifted))
