"""A path in the plane: points joined by straight lines, measured along their length.

x and y are those of the world, in m; a path has a direction, and left is left of that. Curvature is positive where the
path turns left.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain, pairwise

__all__ = ["Path", "PathError", "Place"]

Point = tuple[float, float]

CURVATURE_BASE_M = 3.0
"""Curvature is that of a circle through a point and those so far before and behind it (choice: points of a lane lie a
metre or less apart, and the corners of a polyline must not count)."""

_LEAST_M = 1e-6


class PathError(ValueError):
    """The points make no path."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Where something is, seen from a path.

    Attributes:
        s_m: how far along the path its nearest point is, in m.
        offset_m: how far off it is, in m, positive left.
    """

    s_m: float
    offset_m: float


class Path:
    """A path.

    Args:
        points: at least two, each x and y in m; what follows a point at the same place is left out.
        closed: the last point is joined to the first; it may repeat it.

    Attributes:
        closed: as given.
        length_m: of all of it.

    Raises:
        PathError: there are too few points, or one is not finite.
    """

    def __init__(self, points: Sequence[Point], *, closed: bool = False) -> None:
        if not all(math.isfinite(number) for point in points for number in point):
            raise PathError("a point of a path is not finite")
        kept = list(points[:1])
        for point in points[1:]:
            if math.dist(point, kept[-1]) > _LEAST_M:
                kept.append(point)
        if closed and len(kept) > 1 and math.dist(kept[0], kept[-1]) <= _LEAST_M:
            kept.pop()
        least = 3 if closed else 2
        if len(kept) < least:
            raise PathError(f"a path needs {least} points or more at different places, not {len(kept)}")
        self.closed = closed
        self._points = [*kept, kept[0]] if closed else kept
        self._s_m = [0.0]
        for one, other in pairwise(self._points):
            self._s_m.append(self._s_m[-1] + math.dist(one, other))
        self.length_m = self._s_m[-1]
        self._lines: list[tuple[float, float, float, float, float, float]] = []
        for index, ((ax, ay), (bx, by)) in enumerate(pairwise(self._points)):
            length_m = self._s_m[index + 1] - self._s_m[index]
            self._lines.append((ax, ay, (bx - ax) / length_m, (by - ay) / length_m, self._s_m[index], length_m))

    def normal(self, s_m: float) -> float:
        """The same place as a length of 0 to `length_m`: around a closed path, at the end of an open one."""
        if self.closed:
            return s_m % self.length_m
        return min(max(s_m, 0.0), self.length_m)

    def point(self, s_m: float) -> Point:
        """The point so far along."""
        index, share = self._segment(s_m)
        (ax, ay), (bx, by) = self._points[index : index + 2]
        return ax + share * (bx - ax), ay + share * (by - ay)

    def heading_rad(self, s_m: float) -> float:
        """Where the path goes there, in rad, positive to the left of the x axis."""
        index, _ = self._segment(s_m)
        (ax, ay), (bx, by) = self._points[index : index + 2]
        return math.atan2(by - ay, bx - ax)

    def curvature_per_m(self, s_m: float) -> float:
        """How sharply it turns there, in 1/m, positive left; see `CURVATURE_BASE_M`."""
        (ax, ay), (bx, by), (cx, cy) = (self.point(s_m + d) for d in (-CURVATURE_BASE_M, 0.0, CURVATURE_BASE_M))
        sides = math.dist((ax, ay), (bx, by)) * math.dist((bx, by), (cx, cy)) * math.dist((ax, ay), (cx, cy))
        if sides <= _LEAST_M:
            return 0.0
        return 2 * ((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)) / sides

    def place(self, x_m: float, y_m: float, *, near_m: float | None = None, within_m: float = math.inf) -> Place:
        """Where a point is, seen from the path.

        Args:
            x_m: of the point.
            y_m: of the point.
            near_m: only the path around this length counts, for a path that crosses itself or comes back.
            within_m: so far around it.
        """
        nearest_m, found = math.inf, Place(s_m=0.0, offset_m=0.0)
        # One line of the part is known beforehand: what is farther away than it need not be looked at.
        most_m = math.inf if near_m is None else math.dist((x_m, y_m), self.point(near_m)) + _LEAST_M
        for index in self._around(near_m, within_m):
            ax, ay, dx, dy, start_m, length_m = self._lines[index]
            reach_m = most_m + length_m
            if abs(x_m - ax) > reach_m or abs(y_m - ay) > reach_m:
                continue  # all of this line is farther away
            along_m = min(max((x_m - ax) * dx + (y_m - ay) * dy, 0.0), length_m)
            distance_m = math.dist((x_m, y_m), (ax + along_m * dx, ay + along_m * dy))
            if distance_m < nearest_m:
                left_m = dx * (y_m - ay) - dy * (x_m - ax)
                nearest_m = distance_m
                most_m = min(most_m, distance_m + _LEAST_M)
                found = Place(s_m=self.normal(start_m + along_m), offset_m=math.copysign(distance_m, left_m))
        return found

    def _around(self, near_m: float | None, within_m: float) -> Iterable[int]:
        """The straight lines that reach into a part of the path."""
        count = len(self._points) - 1
        if near_m is None or 2 * within_m >= self.length_m:
            return range(count)
        first, last = (self._segment(near_m + sign * within_m)[0] for sign in (-1, 1))
        return range(first, last + 1) if first <= last else chain(range(first, count), range(last + 1))

    def _segment(self, s_m: float) -> tuple[int, float]:
        s_m = self.normal(s_m)
        index = min(max(bisect_right(self._s_m, s_m) - 1, 0), len(self._s_m) - 2)
        return index, (s_m - self._s_m[index]) / (self._s_m[index + 1] - self._s_m[index])
