"""The test track for a car: a lane that closes on itself, cones to weave between, and a wall for who misses the turn.

Seen from above, driven counter-clockwise::

        slalom   <--
      .--^---v---^---v--.
     (                   )
      '------o-->-------'   | wall
           start

Straights of 120 m, turns of 25 m radius: at 10 m/s a turn asks for 4 m/s². The middle line passes the cones on
alternate sides, 2 m from each; its sharpest bend has a radius of 19 m, which at 10 m/s asks for 5.3 m/s². All figures
are our choice.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from worlds.scenes.model import Box, Lane, Point, Scene

STRAIGHT_M = 120.0
START_AT_M = 30.0
TURN_RADIUS_M = 25.0
LANE_WIDTH_M = 3.5
CONES = 4
CONE_SPACING_M = 20.0
FIRST_CONE_M = 30.0
WEAVE_M = 2.0
WALL_AT_M = 120.0

_POINT_EVERY_M = 0.5
_CONE_SIZE_M = (0.3, 0.3, 0.75)
_WALL_SIZE_M = (0.5, 12.0, 1.0)


def track(seed: int) -> Scene:
    """A closed lane of two straights of 120 m and two turns of 25 m radius, with four cones and a wall."""
    del seed
    wall = Box(name="wall", center_m=(WALL_AT_M + _WALL_SIZE_M[0] / 2, 0.0, _WALL_SIZE_M[2] / 2), size_m=_WALL_SIZE_M)
    return Scene(
        name="test-track",
        boxes=(wall, *_cones()),
        lane=Lane(center_m=tuple(_middle_line()), width_m=LANE_WIDTH_M, closed=True),
    )


def _cones() -> Iterator[Box]:
    for index in range(CONES):
        x, y = _back_straight(FIRST_CONE_M + index * CONE_SPACING_M, 0.0)
        yield Box(name=f"cone_{index + 1}", center_m=(x, y, _CONE_SIZE_M[2] / 2), size_m=_CONE_SIZE_M)


def _middle_line() -> Iterator[Point]:
    """From the start on, as often as `_POINT_EVERY_M`."""
    turn_m = math.pi * TURN_RADIUS_M
    east, west = STRAIGHT_M - START_AT_M, -START_AT_M
    for along in _places(east):
        yield along, 0.0
    for along in _places(turn_m):
        yield _on_circle(east, along / TURN_RADIUS_M - math.pi / 2)
    for along in _places(STRAIGHT_M):
        yield _back_straight(along, _weave_m(along))
    for along in _places(turn_m):
        yield _on_circle(west, along / TURN_RADIUS_M + math.pi / 2)
    for along in _places(START_AT_M):
        yield west + along, 0.0


def _places(length_m: float) -> Iterator[float]:
    """Equally far apart, from 0 and without the end."""
    count = round(length_m / _POINT_EVERY_M)
    return (length_m * index / count for index in range(count))


def _on_circle(x_m: float, angle_rad: float) -> Point:
    return x_m + TURN_RADIUS_M * math.cos(angle_rad), TURN_RADIUS_M * (1 + math.sin(angle_rad))


def _back_straight(along_m: float, left_m: float) -> Point:
    return STRAIGHT_M - START_AT_M - along_m, 2 * TURN_RADIUS_M - left_m


def _weave_m(along_m: float) -> float:
    """How far the line is to the left of the cones: it swings in before the first and out after the last."""
    last_m = FIRST_CONE_M + (CONES - 1) * CONE_SPACING_M
    to_cones_m = max(FIRST_CONE_M - along_m, along_m - last_m, 0.0)
    swing = _smooth(1 - to_cones_m / FIRST_CONE_M)
    return WEAVE_M * swing * math.cos(math.pi * (along_m - FIRST_CONE_M) / CONE_SPACING_M)


def _smooth(place: float) -> float:
    """From 0 to 1 with neither a kink nor a step of curvature at either end."""
    place = max(0.0, min(1.0, place))
    return place**3 * (10 - 15 * place + 6 * place * place)
