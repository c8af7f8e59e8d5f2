"""What a scene is: a floor, boxes that stand on it and the place where the vehicle starts.

Scenes are plain data, so the same boxes feed the physics, the exact geometry the tests judge by, and pictures from
above. SI units; x forward, y left, z up; yaw counter-clockwise seen from above.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

Point = tuple[float, float]
Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """A fixed box.

    Attributes:
        name: unique within the scene; contacts report it.
        center_m: middle of the box, in the scene's frame, metres.
        size_m: full edge lengths along the box's own x, y, z, metres, each > 0.
        yaw_rad: turn about z, applied after the pitch, radians.
        pitch_rad: turn about the box's y, radians; negative lifts the far (+x) end, as a ramp does.
        friction: Coulomb coefficient; physics multiplies it with the vehicle's own.
    """

    name: str
    center_m: Vector
    size_m: Vector
    yaw_rad: float = 0.0
    pitch_rad: float = 0.0
    friction: float = 1.0

    def outline_m(self) -> tuple[Point, Point, Point, Point]:
        """Return the corners of the box's shadow on the floor, counter-clockwise, metres."""
        length, width, height = self.size_m
        half_x = (abs(math.cos(self.pitch_rad)) * length + abs(math.sin(self.pitch_rad)) * height) / 2
        half_y = width / 2
        cos, sin = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        x, y, _ = self.center_m

        def corner(along: float, across: float) -> Point:
            return (x + cos * along - sin * across, y + sin * along + cos * across)

        return corner(half_x, half_y), corner(-half_x, half_y), corner(-half_x, -half_y), corner(half_x, -half_y)


@dataclass(frozen=True, slots=True, kw_only=True)
class Start:
    """Where the vehicle's reference point begins, at rest: metres and radians; ``z_m`` is 0 on the floor."""

    x_m: float = 0.0
    y_m: float = 0.0
    z_m: float = 0.0
    yaw_rad: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Lane:
    """Where a vehicle is meant to drive. Paint, not an obstacle: the physics does not know it.

    Attributes:
        center_m: points of its middle line in the direction of travel, the first beside the start, metres.
        width_m: from edge to edge, metres.
        closed: whether the last point is followed by the first.
    """

    center_m: tuple[Point, ...]
    width_m: float
    closed: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """A floor without edges and the boxes on it.

    Attributes:
        name: what reports call the scene.
        start: the vehicle's pose at the first step.
        boxes: the fixed obstacles, in loading order (the order is part of a run's identity).
        floor_friction: Coulomb coefficient of the floor; at 1.0 the vehicle's own value is the real one.
        lane: where to drive, if the scene says so.
    """

    name: str
    start: Start = Start()
    boxes: tuple[Box, ...] = ()
    floor_friction: float = 1.0
    lane: Lane | None = None

    @property
    def endless(self) -> bool:
        """Whether nothing stands on the floor, so that a vehicle may drive for ever."""
        return not self.boxes

    def outlines_m(self) -> dict[str, tuple[Point, ...]]:
        """Return each box's outline seen from above, by name, corners counter-clockwise in metres."""
        return {box.name: box.outline_m() for box in self.boxes}

    def free_ahead_m(self, half_width_m: float = 0.25) -> float:
        """Return how far straight ahead of the start the floor stays flat and free.

        The distance runs from the start point along the start's heading, so a caller subtracts what its vehicle
        sticks out in front. A ramp counts as not free: the floor is no longer flat there.

        Args:
            half_width_m: half the width of the lane that must be free, metres; 0.25 is the swing radius of a
                Pioneer 2-DX in AriaCoda params/p2dx.p (RobotRadius).

        Returns:
            Metres, ``math.inf`` when nothing stands in the lane.
        """
        return min((_lane_entry(self._from_start(box), half_width_m) for box in self.boxes), default=math.inf)

    def _from_start(self, box: Box) -> list[Point]:
        cos, sin = math.cos(self.start.yaw_rad), math.sin(self.start.yaw_rad)
        return [
            (
                cos * (x - self.start.x_m) + sin * (y - self.start.y_m),
                cos * (y - self.start.y_m) - sin * (x - self.start.x_m),
            )
            for x, y in box.outline_m()
        ]


def _lane_entry(corners: list[Point], half_width_m: float) -> float:
    """Smallest x >= 0 at which a convex outline reaches into the lane ``|y| <= half_width_m``."""
    reached = [x for x, y in corners if abs(y) <= half_width_m]
    for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True):
        crossed = [side for side in (-half_width_m, half_width_m) if (y0 - side) * (y1 - side) < 0]
        reached += [x0 + (x1 - x0) * (side - y0) / (y1 - y0) for side in crossed]
    return min((x for x in reached if x >= 0), default=math.inf)
