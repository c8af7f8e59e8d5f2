"""The scenes that come with hilbench. All sizes are our choice; nothing here is measured from a real place."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from types import MappingProxyType

from worlds.scenes.model import Box, Scene, Start
from worlds.scenes.track import track

ROOM_SIDE_M = 10.0
ROOM_BOXES = 12
ROOM_CLEAR_RADIUS_M = 1.5
CORRIDOR_WIDTH_M = 2.0
CORRIDOR_LENGTH_M = 20.0
RAMP_FOOT_M = 1.5
RAMP_LENGTH_M = 3.0
RAMP_SLOPE_RAD = math.radians(8)
POST_WIDTH_M = 0.04
CELL_LENGTH_M = 1.15
CELL_WIDTH_M = 0.9
STAND_LIFT_M = 0.03
STAND_HEIGHT_M = 0.052
HARD_FLOOR_FRICTION = 0.5
ROVER_ROOM_LENGTH_M = 3.0
ROVER_ROOM_WIDTH_M = 2.4

_WALL_HEIGHT_M = 0.5
_WALL_THICKNESS_M = 0.1


def empty(seed: int) -> Scene:
    """A floor and nothing else."""
    del seed
    return Scene(name="empty")


def wall(seed: int) -> Scene:
    """A wall across the way whose face is 2 m ahead of the start."""
    del seed
    return Scene(name="wall", boxes=(_wall("wall", 2.0 + _WALL_THICKNESS_M / 2, 0.0, _WALL_THICKNESS_M, 4.0),))


def room_with_boxes(seed: int) -> Scene:
    """A room of 10 x 10 m with twelve seeded boxes, none within 1.5 m of the start in the middle.

    Boxes never overlap and leave 0.7 m between them, so that a Pioneer (0.425 m wide) can pass anywhere.
    """
    rng = random.Random(seed)
    boxes: list[Box] = []
    while len(boxes) < ROOM_BOXES:
        candidate = _random_box(rng, f"box_{len(boxes) + 1}")
        if _distance_m(candidate, 0.0, 0.0) < ROOM_CLEAR_RADIUS_M + _radius_m(candidate):
            continue
        if all(_gap_m(candidate, other) >= 0.7 for other in boxes):
            boxes.append(candidate)
    return Scene(name="room-with-boxes", boxes=(*_room_walls(), *boxes))


def corridor(seed: int) -> Scene:
    """A corridor 2 m wide and 20 m long, closed at both ends; the start is on its middle line, 1 m from one end."""
    del seed
    middle, side, t = CORRIDOR_LENGTH_M / 2 - 1.0, CORRIDOR_WIDTH_M / 2, _WALL_THICKNESS_M
    return Scene(
        name="corridor",
        boxes=(
            _wall("wall_left", middle, side + t / 2, CORRIDOR_LENGTH_M, t),
            _wall("wall_right", middle, -side - t / 2, CORRIDOR_LENGTH_M, t),
            _wall("end_far", CORRIDOR_LENGTH_M - 1.0 + t / 2, 0.0, t, CORRIDOR_WIDTH_M),
            _wall("end_near", -1.0 - t / 2, 0.0, t, CORRIDOR_WIDTH_M),
        ),
    )


def ramp(seed: int) -> Scene:
    """A slope of 8 degrees, 3 m long, whose foot is 1.5 m ahead of the start, with a flat top of 2 m behind it."""
    del seed
    thickness, width, top_m = 0.5, 2.0, 2.0
    cos, sin = math.cos(RAMP_SLOPE_RAD), math.sin(RAMP_SLOPE_RAD)
    rise, end_x = RAMP_LENGTH_M * sin, RAMP_FOOT_M + RAMP_LENGTH_M * cos
    slope = Box(
        name="slope",
        center_m=(
            RAMP_FOOT_M + RAMP_LENGTH_M / 2 * cos + thickness / 2 * sin,
            0.0,
            RAMP_LENGTH_M / 2 * sin - thickness / 2 * cos,
        ),
        size_m=(RAMP_LENGTH_M, width, thickness),
        pitch_rad=-RAMP_SLOPE_RAD,
    )
    top = Box(name="top", center_m=(end_x + top_m / 2, 0.0, rise / 2), size_m=(top_m, width, rise))
    return Scene(name="ramp", start=Start(), boxes=(slope, top))


def post(seed: int) -> Scene:
    """A square post of 40 mm, 3 m ahead of the start: something that one sensor can see alone."""
    del seed
    box = Box(name="post", center_m=(3.0, 0.0, _WALL_HEIGHT_M / 2), size_m=(POST_WIDTH_M, POST_WIDTH_M, _WALL_HEIGHT_M))
    return Scene(name="post", boxes=(box,))


def cell(seed: int) -> Scene:
    """A closed cell of 1.15 x 0.9 m round a point 3 m ahead of the start: just room for a Pioneer, walls all round."""
    del seed
    x, half, side, t = 3.0, CELL_LENGTH_M / 2, CELL_WIDTH_M / 2, _WALL_THICKNESS_M
    return Scene(
        name="cell",
        boxes=(
            _wall("wall_front", x + half + t / 2, 0.0, t, CELL_WIDTH_M + 2 * t),
            _wall("wall_back", x - half - t / 2, 0.0, t, CELL_WIDTH_M + 2 * t),
            _wall("wall_left", x, side + t / 2, CELL_LENGTH_M, t),
            _wall("wall_right", x, -side - t / 2, CELL_LENGTH_M, t),
        ),
    )


def stand(seed: int) -> Scene:
    """A rover on a stand under its body, with its wheels 30 mm above the floor.

    As high as the rover's body needs: 52 mm, which is 22 mm from wheels to body and the 30.
    """
    del seed
    block = Box(name="stand", center_m=(0.0, 0.0, STAND_HEIGHT_M / 2), size_m=(0.2, 0.09, STAND_HEIGHT_M))
    return Scene(name="stand", start=Start(z_m=STAND_LIFT_M), boxes=(block,))


def carpet(seed: int) -> Scene:
    """A carpet without end: tyres have their own friction on it, a rover's 0.8."""
    del seed
    return Scene(name="carpet")


def hard_floor(seed: int) -> Scene:
    """A smooth hard floor without end: half the friction of the carpet, 0.4 for a rover's tyres."""
    del seed
    return Scene(name="hard-floor", floor_friction=HARD_FLOOR_FRICTION)


def rover_room(seed: int) -> Scene:
    """A room of 3 x 2.4 m with a hard floor and two boxes; a wall is 1.4 m ahead of the start, nothing before it."""
    del seed
    length, width, t = ROVER_ROOM_LENGTH_M, ROVER_ROOM_WIDTH_M, _WALL_THICKNESS_M
    x = 1.4 - length / 2
    return Scene(
        name="rover-room",
        boxes=(
            _wall("wall_front", x + (length + t) / 2, 0.0, t, width + 2 * t),
            _wall("wall_back", x - (length + t) / 2, 0.0, t, width + 2 * t),
            _wall("wall_left", x, (width + t) / 2, length, t),
            _wall("wall_right", x, -(width + t) / 2, length, t),
            Box(name="box_1", center_m=(0.6, 0.75, 0.1), size_m=(0.3, 0.3, 0.2), yaw_rad=0.4),
            Box(name="box_2", center_m=(-0.7, -0.6, 0.1), size_m=(0.25, 0.4, 0.2), yaw_rad=-0.3),
        ),
        floor_friction=HARD_FLOOR_FRICTION,
    )


BUILTIN: MappingProxyType[str, Callable[[int], Scene]] = MappingProxyType(
    {
        "empty": empty,
        "wall": wall,
        "room-with-boxes": room_with_boxes,
        "corridor": corridor,
        "ramp": ramp,
        "post": post,
        "cell": cell,
        "stand": stand,
        "carpet": carpet,
        "hard-floor": hard_floor,
        "rover-room": rover_room,
        "test-track": track,
    }
)
"""Scene by name; each is made from a seed, which only the room uses."""


def _wall(name: str, x_m: float, y_m: float, length_m: float, width_m: float) -> Box:
    return Box(name=name, center_m=(x_m, y_m, _WALL_HEIGHT_M / 2), size_m=(length_m, width_m, _WALL_HEIGHT_M))


def _room_walls() -> tuple[Box, ...]:
    middle, span, t = (ROOM_SIDE_M + _WALL_THICKNESS_M) / 2, ROOM_SIDE_M + 2 * _WALL_THICKNESS_M, _WALL_THICKNESS_M
    return (
        _wall("wall_front", middle, 0.0, t, span),
        _wall("wall_back", -middle, 0.0, t, span),
        _wall("wall_left", 0.0, middle, span, t),
        _wall("wall_right", 0.0, -middle, span, t),
    )


def _random_box(rng: random.Random, name: str) -> Box:
    reach = ROOM_SIDE_M / 2 - 0.6
    return Box(
        name=name,
        center_m=(rng.uniform(-reach, reach), rng.uniform(-reach, reach), 0.2),
        size_m=(rng.uniform(0.3, 0.6), rng.uniform(0.3, 0.6), 0.4),
        yaw_rad=rng.uniform(-math.pi, math.pi),
    )


def _distance_m(box: Box, x_m: float, y_m: float) -> float:
    return math.hypot(box.center_m[0] - x_m, box.center_m[1] - y_m)


def _radius_m(box: Box) -> float:
    return math.hypot(box.size_m[0], box.size_m[1]) / 2


def _gap_m(one: Box, other: Box) -> float:
    return _distance_m(one, other.center_m[0], other.center_m[1]) - _radius_m(one) - _radius_m(other)
