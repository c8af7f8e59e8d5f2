"""Motor codes to a velocity, and a velocity to the numbers of VEL and RVEL (bluepill_comm.cpp, p2os_comm.cpp).

The published arithmetic maps the sum of both codes to -500..500 mm/s and their difference to -340..340 mrad/s, halves
both, and drops what is behind the point at each step. Both codes 3 are 187 mm/s, both -4 are -250 mm/s. By its own
scale of 62.5 mm/s per code two wheels 0.357 m apart would turn at 175 mrad/s per unit of difference; it asks for 21.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from targets.parts.gamepad import c_scale
from targets.parts.p2os_adapter.settings import P2osAdapterSettings

__all__ = ["STILL", "Velocity", "velocity_of_codes", "wire_speeds"]

_CODES = (-8, 8)
"""Range of a sum or difference of two codes, as the published code has it."""


class Velocity(NamedTuple):
    """Speed forward in m/s, rotation counter-clockwise in rad/s."""

    speed_m_s: float
    turn_rad_s: float


STILL = Velocity(0.0, 0.0)


def velocity_of_codes(left: int, right: int, settings: P2osAdapterSettings) -> Velocity:
    """The velocity that two codes (-4..3) ask for."""
    speed_range, turn_range = settings.speed_range_mm_s, settings.turn_range_mrad_s
    if settings.integer_arithmetic:
        speed_mm_s: float = _halved(c_scale(left + right, _CODES, (-speed_range, speed_range)))
        turn_mrad_s: float = _halved(c_scale(right - left, _CODES, (-turn_range, turn_range)))
    else:
        speed_mm_s = (left + right) * speed_range / 16
        turn_mrad_s = (right - left) * turn_range / 16
    if settings.turning == "differential":
        turn_mrad_s = (right - left) * (speed_range / 8) / settings.track_m
        turn_mrad_s = math.trunc(turn_mrad_s) if settings.integer_arithmetic else turn_mrad_s
    return Velocity(speed_mm_s / 1000, turn_mrad_s / 1000)


def wire_speeds(velocity: Velocity, settings: P2osAdapterSettings) -> tuple[int, int]:
    """The arguments of VEL (mm/s) and RVEL (deg/s), within the limits of the library."""
    speed_mm_s = velocity.speed_m_s * 1e3
    speed = math.trunc(speed_mm_s) if settings.integer_arithmetic else round(speed_mm_s)
    turn = round(math.degrees(velocity.turn_rad_s))
    return _limited(speed, settings.speed_limit_mm_s), _limited(turn, settings.turn_limit_deg_s)


def _halved(number: int) -> int:
    """Half of a whole number, toward zero as in C."""
    return math.trunc(number / 2)


def _limited(number: int, limit: int) -> int:
    return max(-limit, min(limit, number))
