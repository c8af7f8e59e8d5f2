"""What one sonar disc hears along: a cone, sampled by thirteen rays.

They are its axis, four to the left and four to the right a quarter of its half-angle apart, and two upwards and two
downwards at half and at the whole of it (choice).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from worlds.geometry import Vector, add, rotation, turn

__all__ = ["Disc", "disc_at"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Disc:
    """A disc in the vehicle's frame.

    Attributes:
        face_m: where its rays start.
        ends_m: where they end at full range, that of the axis first.
    """

    face_m: Vector
    ends_m: tuple[Vector, ...]


def disc_at(face_m: Vector, heading_rad: float, half_angle_rad: float, range_m: float) -> Disc:
    """Return a disc.

    Args:
        face_m: its middle, in the vehicle's frame.
        heading_rad: of its axis, which is level.
        half_angle_rad: of the cone.
        range_m: how far it hears.
    """
    facing = rotation(heading_rad)
    ends = tuple(add(face_m, turn(facing, ray), range_m) for ray in _cone(half_angle_rad))
    return Disc(face_m=face_m, ends_m=ends)


def _cone(half_angle_rad: float) -> list[Vector]:
    """Unit vectors about x: the axis, then left and right, then up and down."""
    rays: list[Vector] = [(1.0, 0.0, 0.0)]
    for share in (0.25, 0.5, 0.75, 1.0):
        along, across = math.cos(share * half_angle_rad), math.sin(share * half_angle_rad)
        rays += [(along, across, 0.0), (along, -across, 0.0)]
    for share in (0.5, 1.0):
        along, across = math.cos(share * half_angle_rad), math.sin(share * half_angle_rad)
        rays += [(along, 0.0, across), (along, 0.0, -across)]
    return rays
