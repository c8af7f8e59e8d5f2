"""Exact distances from scene data, without any physics library.

The physics answers rays by its own collision shapes; the same question asked here is answered from the boxes the
scene was written with. Tests hold one against the other, and checks may use this side as the truth.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from worlds.scenes.model import Box

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]


def dot(one: Vector, other: Vector) -> float:
    """Return the scalar product."""
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def add(one: Vector, other: Vector, scale: float = 1.0) -> Vector:
    """Return ``one + scale * other``."""
    return one[0] + scale * other[0], one[1] + scale * other[1], one[2] + scale * other[2]


def subtract(one: Vector, other: Vector) -> Vector:
    """Return ``one - other``."""
    return one[0] - other[0], one[1] - other[1], one[2] - other[2]


def cross(one: Vector, other: Vector) -> Vector:
    """Return the vector product."""
    return (
        one[1] * other[2] - one[2] * other[1],
        one[2] * other[0] - one[0] * other[2],
        one[0] * other[1] - one[1] * other[0],
    )


def rotation(yaw_rad: float, pitch_rad: float = 0.0, roll_rad: float = 0.0) -> Matrix:
    """Return the rows of the matrix that turns by roll about x, then pitch about y, then yaw about z."""
    cy, sy = math.cos(yaw_rad), math.sin(yaw_rad)
    cp, sp = math.cos(pitch_rad), math.sin(pitch_rad)
    cr, sr = math.cos(roll_rad), math.sin(roll_rad)
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def turn(matrix: Matrix, vector: Vector) -> Vector:
    """Return ``matrix @ vector``."""
    (a, b, c), (d, e, f), (g, h, i) = matrix
    x, y, z = vector
    return a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z


def turn_back(matrix: Matrix, vector: Vector) -> Vector:
    """Return ``matrix.T @ vector``, the inverse turn."""
    (a, b, c), (d, e, f), (g, h, i) = matrix
    x, y, z = vector
    return a * x + d * y + g * z, b * x + e * y + h * z, c * x + f * y + i * z


def ray_distance_m(start_m: Vector, direction: Vector, boxes: Iterable[Box]) -> float | None:
    """Return how far along a ray the nearest box is, metres, or None where the ray meets none.

    Args:
        start_m: where the ray begins; 0.0 is returned when that is inside a box.
        direction: a unit vector.
        boxes: what may stand in the way.
    """
    hits = [hit for box in boxes if (hit := _ray_to_box(start_m, direction, box)) is not None]
    return min(hits, default=None)


def cone_distance_m(apex_m: Vector, axis: Vector, half_angle_rad: float, boxes: Iterable[Box]) -> float | None:
    """Return the distance to the nearest point of any box inside a cone, metres, or None where there is none.

    Args:
        apex_m: the tip, outside every box.
        axis: a unit vector.
        half_angle_rad: between 0 and pi/2, radians.
        boxes: what may stand in the way.
    """
    points = (point for box in boxes for point in _nearest_in_cone(apex_m, axis, half_angle_rad, box))
    return min((math.dist(point, apex_m) for point in points), default=None)


def _ray_to_box(start_m: Vector, direction: Vector, box: Box) -> float | None:
    frame = rotation(box.yaw_rad, box.pitch_rad)
    origin = turn_back(frame, subtract(start_m, box.center_m))
    heading = turn_back(frame, direction)
    enters, leaves = 0.0, math.inf
    for position, speed, size in zip(origin, heading, box.size_m, strict=True):
        if speed == 0.0:
            if abs(position) > size / 2:
                return None
            continue
        near, far = sorted(((-size / 2 - position) / speed, (size / 2 - position) / speed))
        enters, leaves = max(enters, near), min(leaves, far)
    return enters if enters <= leaves else None


def _nearest_in_cone(apex_m: Vector, axis: Vector, half_angle_rad: float, box: Box) -> Iterator[Vector]:
    """Yield, per face that sees the apex, the points among which the nearest one inside the cone is.

    On the plane of a face the distance is least in the direction of the cone nearest to the plane's normal. If that
    point lies outside the face, the least distance is on one of its edges, since face, cone and distance are convex.
    """
    frame = rotation(box.yaw_rad, box.pitch_rad)
    columns = tuple(turn(frame, unit) for unit in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    for index in range(3):
        for sign in (-1.0, 1.0):
            normal = add((0.0, 0.0, 0.0), columns[index], sign)
            middle = add(box.center_m, normal, box.size_m[index] / 2)
            height = dot(subtract(apex_m, middle), normal)
            if height <= 0:
                continue
            sides = [(columns[other], box.size_m[other] / 2) for other in range(3) if other != index]
            direction = _towards(axis, half_angle_rad, normal)
            if direction is not None:
                point = add(apex_m, direction, height / -dot(direction, normal))
                if all(abs(dot(subtract(point, middle), side)) <= half for side, half in sides):
                    yield point
                    continue
            for start, end in _edges(middle, sides):
                yield from _nearest_on_edge(apex_m, axis, half_angle_rad, start, end)


def _towards(axis: Vector, half_angle_rad: float, normal: Vector) -> Vector | None:
    """The direction in the cone that is nearest to ``-normal``; None if no direction of the cone goes that way."""
    angle = math.acos(max(-1.0, min(1.0, -dot(axis, normal))))
    if angle <= half_angle_rad:
        return add((0.0, 0.0, 0.0), normal, -1.0)
    if angle - half_angle_rad >= math.pi / 2:
        return None
    across = add((0.0, 0.0, 0.0), normal, -1.0)
    across = add(across, axis, -dot(across, axis))
    length = math.sqrt(dot(across, across))
    scaled = add((0.0, 0.0, 0.0), axis, math.cos(half_angle_rad))
    return add(scaled, across, math.sin(half_angle_rad) / length)


def _edges(middle: Vector, sides: list[tuple[Vector, float]]) -> Iterator[tuple[Vector, Vector]]:
    for (along, half_along), (across, half_across) in (sides, sides[::-1]):
        for sign in (-1.0, 1.0):
            foot = add(middle, across, sign * half_across)
            yield add(foot, along, -half_along), add(foot, along, half_along)


def _nearest_on_edge(
    apex_m: Vector, axis: Vector, half_angle_rad: float, start: Vector, end: Vector
) -> Iterator[Vector]:
    """Yield the candidates on an edge: its point nearest to the apex, its ends, and where it crosses the cone."""
    along, offset = subtract(end, start), subtract(start, apex_m)
    limit = math.cos(half_angle_rad) ** 2
    a1, a0 = dot(along, axis), dot(offset, axis)
    square = a1 * a1 - limit * dot(along, along)
    linear = 2 * (a1 * a0 - limit * dot(along, offset))
    rest = a0 * a0 - limit * dot(offset, offset)
    for place in (0.0, 1.0, -dot(offset, along) / dot(along, along)):
        if 0.0 <= place <= 1.0:
            inside = dot(add(offset, along, place), axis)
            if inside > 0 and square * place * place + linear * place + rest >= 0:
                yield add(start, along, place)
    for place in _roots(square, linear, rest):
        if 0.0 <= place <= 1.0 and dot(add(offset, along, place), axis) > 0:
            yield add(start, along, place)


def _roots(square: float, linear: float, rest: float) -> tuple[float, ...]:
    if square == 0.0:
        return (-rest / linear,) if linear else ()
    inside = linear * linear - 4 * square * rest
    if inside < 0:
        return ()
    root = math.sqrt(inside)
    return (-linear - root) / (2 * square), (-linear + root) / (2 * square)
