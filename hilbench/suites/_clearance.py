"""How near a vehicle has come to the boxes of its scene, seen from above.

The vehicle is the convex outline of all its boxes and wheels, turned and moved with it; an obstacle is its outline on
the floor. So this is a distance of polygons, and 0 where they overlap.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from worlds.scenes import Scene
from worlds.vehicles import Vehicle
from worlds.vehicles.model import SphereShape
from worlds.world import Pose

__all__ = ["Clearance", "outline_m"]

Point = tuple[float, float]

_IN_REACH_M = 2.0
"""What is farther from the vehicle's reference point is not looked at (a choice: nothing depends on it)."""


class Clearance:
    """Keeps the least distance seen so far.

    Args:
        vehicle: what moves.
        scene: what stands.

    Attributes:
        least_m: between the two, so far; infinite while nothing was in reach.
    """

    def __init__(self, vehicle: Vehicle, scene: Scene) -> None:
        self.least_m = math.inf
        self._outline = outline_m(vehicle)
        self._boxes = [box.outline_m() for box in scene.boxes]

    def look(self, pose: Pose) -> None:
        """Take the vehicle as it stands now."""
        x, y, _ = pose.position_m
        cos, sin = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
        outline = [(x + cos * px - sin * py, y + sin * px + cos * py) for px, py in self._outline]
        for box in self._boxes:
            if _point_to_polygon_m((x, y), box) < _IN_REACH_M:
                self.least_m = min(self.least_m, _between_m(outline, box))


def outline_m(vehicle: Vehicle) -> list[Point]:
    """Return the convex outline of a vehicle from above, in its own frame, counter-clockwise."""
    shapes = (shape for part in vehicle.parts for shape in part.shapes if not isinstance(shape, SphereShape))
    return _hull([corner for shape in shapes for corner in shape.outline_m()])


def _hull(points: Iterable[Point]) -> list[Point]:
    """Return the convex hull, by the monotone chain of Andrew."""
    ordered = sorted(set(points))
    return [*_chain(ordered)[:-1], *_chain(ordered[::-1])[:-1]]


def _chain(points: Sequence[Point]) -> list[Point]:
    chain: list[Point] = []
    for point in points:
        while len(chain) > 1 and _turn(chain[-2], chain[-1], point) <= 0:
            chain.pop()
        chain.append(point)
    return chain


def _turn(one: Point, two: Point, three: Point) -> float:
    return (two[0] - one[0]) * (three[1] - one[1]) - (two[1] - one[1]) * (three[0] - one[0])


def _between_m(one: Sequence[Point], other: Sequence[Point]) -> float:
    """Return the distance of two convex polygons. Where they do not overlap, a corner of one is next to the other."""
    corners = [_point_to_polygon_m(point, other) for point in one]
    return min(corners + [_point_to_polygon_m(point, one) for point in other])


def _point_to_polygon_m(point: Point, polygon: Sequence[Point]) -> float:
    edges = list(zip(polygon, [*polygon[1:], polygon[0]], strict=True))
    if all(_turn(start, end, point) >= 0 for start, end in edges):
        return 0.0
    return min(_point_to_edge_m(point, start, end) for start, end in edges)


def _point_to_edge_m(point: Point, start: Point, end: Point) -> float:
    along = (end[0] - start[0], end[1] - start[1])
    square = along[0] ** 2 + along[1] ** 2
    share = ((point[0] - start[0]) * along[0] + (point[1] - start[1]) * along[1]) / square
    share = min(1.0, max(0.0, share))
    return math.hypot(point[0] - start[0] - share * along[0], point[1] - start[1] - share * along[1])
