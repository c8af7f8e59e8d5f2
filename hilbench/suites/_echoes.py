"""What the sonar discs must report, from the boxes of the scene alone.

A disc hears the nearest thing in its cone. So its range is never shorter than the distance to the nearest point of any
box in the cone, and never longer than the distance along any single line inside the cone. The first is computed
exactly; of the lines thirteen are taken, so that a sonar that samples its cone as coarsely as that is not accused.
Between the two lies everything that a sonar with this cone may say.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from hilbench.check import at_least, record_measure, within
from hilbench.suites._session import Session
from protocols.p2os import RobotParameters, sonar_range_mm
from worlds.geometry import Matrix, Vector, add, cone_distance_m, ray_distance_m, rotation, turn
from worlds.scenes import Box
from worlds.vehicles.pioneer_2dx import DEFAULTS
from worlds.world import World

LINES_DEG = (
    (0.0, 0.0),
    *((side * angle, 0.0) for angle in (3.75, 7.5, 11.25, 15.0) for side in (1, -1)),
    *((0.0, up * angle) for angle in (7.5, 15.0) for up in (1, -1)),
)
"""The lines: how far to the left of the axis, and how far above it. Neighbours to the left and right are 3.75 degrees
apart, so that a wall wider than the cone is heard at most 1 / cos(1.875 degrees) = 1.00054 times too far."""

EDGE_M = 2e-3
"""How much wider or slimmer than in the scene a box may seem to a line that grazes its edge: the collision shapes of
the physics have a margin."""

ROUNDING = 1.0
"""Units of the SIP by which a range may be off: half of one for rounding, all of it for a robot that cuts off."""

ARRAY = 8
"""Discs that every Pioneer 2-DX has: the front array."""

ROUND_S = 0.5
"""Eight discs of an array fire in 8 x 40 ms (Pioneer 2 Operations Manual, sonar), and what a SIP lists is up to 100 ms
old."""


def require_echoes(session: Session, world: World, where: str) -> None:
    """Require that each disc reports what is in its cone; the robot is at rest, ``where`` says at which place."""
    session.watch_alive(ROUND_S)  # what was fired under way
    seen = session.watch_alive(ROUND_S)
    heard = {reading.number: reading.range_raw for s in seen for reading in s.sip.sonars}
    fitted = [number for number, disc in enumerate(session.robot.sonars) if disc is not None]
    strange = sorted(heard.keys() - set(fitted))
    assert not strange, f"readings of discs that are not there: {strange}"
    missing = sorted(set(fitted[:ARRAY]) - heard.keys())
    assert not missing, f"no readings within {ROUND_S} s {where} of the discs {missing}"
    expected = {number: expect_echo(world, session.robot, number) for number in heard}
    ranges_mm = {number: sonar_range_mm(raw, session.robot) for number, raw in sorted(heard.items())}
    for number, range_mm in ranges_mm.items():
        require_range(range_mm, expected[number], f"range of disc {number} {where}")
    near = [number for number in ranges_mm if math.isfinite(expected[number].high_mm)]
    assert near, f"{where} there is nothing within range of any disc, and nothing is checked"
    from_cone = max((ranges_mm[number] - expected[number].cone_mm for number in near), key=abs)
    from_lines = max((ranges_mm[number] - expected[number].lines_mm for number in near), key=abs)
    record_measure(f"range less that of the exact cone, worst of {len(near)} discs {where}", from_cone, "mm")
    record_measure(
        f"range less that of the {len(LINES_DEG)} lines, worst of {len(near)} discs {where}", from_lines, "mm"
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Expected:
    """What a disc may report, in mm; infinite stands for no echo.

    Attributes:
        cone_mm: distance to the nearest point in the cone.
        lines_mm: distance to the nearest point on one of the lines.
        low_mm: the shortest range allowed.
        high_mm: the longest range allowed.
    """

    cone_mm: float
    lines_mm: float
    low_mm: float
    high_mm: float


def require_range(range_mm: float, expected: Expected, what: str) -> None:
    """Require what a disc reports; where it may hear nothing, anything beyond the nearest thing in its cone will do."""
    if math.isinf(expected.high_mm):
        at_least(range_mm, min(expected.low_mm, DEFAULTS.sonar_range_m * 1000), unit="mm", what=what)
    else:
        within(range_mm, expected.low_mm, expected.high_mm, unit="mm", what=what)


def expect_echo(world: World, robot: RobotParameters, number: int) -> Expected:
    """Return what a disc may report where the robot is now."""
    disc, pose, boxes = robot.sonars[number], world.pose(), world.scene.boxes
    assert disc is not None
    frame = rotation(pose.yaw_rad, pose.pitch_rad, pose.roll_rad)
    face = add(pose.position_m, turn(frame, (disc.x_mm / 1000, disc.y_mm / 1000, DEFAULTS.sonar_height_m)))
    rounding_mm = ROUNDING * robot.range_unit_mm
    return Expected(
        cone_mm=1000 * _cone_m(face, frame, disc.th_rad, boxes),
        lines_mm=1000 * _lines_m(face, frame, disc.th_rad, boxes),
        low_mm=1000 * _cone_m(face, frame, disc.th_rad, _grown(boxes, EDGE_M)) - rounding_mm,
        high_mm=1000 * _lines_m(face, frame, disc.th_rad, _grown(boxes, -EDGE_M)) + rounding_mm,
    )


def _cone_m(face: Vector, frame: Matrix, th_rad: float, boxes: Sequence[Box]) -> float:
    return _audible(cone_distance_m(face, _line(frame, th_rad, 0, 0), DEFAULTS.sonar_half_angle_rad, boxes))


def _lines_m(face: Vector, frame: Matrix, th_rad: float, boxes: Sequence[Box]) -> float:
    return min(_audible(ray_distance_m(face, _line(frame, th_rad, left, up), boxes)) for left, up in LINES_DEG)


def _line(frame: Matrix, th_rad: float, left_deg: float, up_deg: float) -> Vector:
    """The direction of a line in the cone of a disc that looks in the direction ``th_rad``, as a unit vector."""
    in_cone = turn(rotation(math.radians(left_deg), -math.radians(up_deg)), (1.0, 0.0, 0.0))
    return turn(frame, turn(rotation(th_rad), in_cone))


def _audible(distance_m: float | None) -> float:
    """Infinite for nothing and for what is too far to be heard; never in the blind zone."""
    if distance_m is None or distance_m > DEFAULTS.sonar_range_m:
        return math.inf
    return max(distance_m, DEFAULTS.sonar_blind_m)


def _grown(boxes: Sequence[Box], by_m: float) -> list[Box]:
    """The boxes with every face moved outwards by ``by_m``."""
    return [
        replace(box, size_m=(box.size_m[0] + 2 * by_m, box.size_m[1] + 2 * by_m, box.size_m[2] + 2 * by_m))
        for box in boxes
    ]
