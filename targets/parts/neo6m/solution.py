"""What the receiver knows at the moment of one solution."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

from targets.parts.neo6m.geodesy import Geodetic, Vector
from targets.parts.neo6m.gps_time import Utc
from targets.parts.neo6m.sky import Dops, Satellite

__all__ = ["Fix", "Motion", "Solution"]


class Fix(enum.IntEnum):
    """Values of gpsFix (UBX-NAV-STATUS)."""

    NONE = 0
    FIX_2D = 2
    FIX_3D = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """Where the antenna is, and how it moves, with the receiver's errors.

    Attributes:
        place: latitude, longitude, height.
        ecef_m: the same.
        enu_m_s: velocity to the east, to the north, up.
        ecef_m_s: the same.
        course_deg: course over ground, 0..360, clockwise from north.
        course_frozen: it is that of before, for it moves too slowly now to have one.
    """

    place: Geodetic
    ecef_m: Vector
    enu_m_s: Vector
    ecef_m_s: Vector
    course_deg: float
    course_frozen: bool

    @property
    def ground_m_s(self) -> float:
        """Speed over ground."""
        return math.hypot(*self.enu_m_s[:2])


@dataclass(frozen=True, slots=True, kw_only=True)
class Solution:
    """One epoch.

    Attributes:
        gps_ns: its time since the GPS epoch.
        utc: the same as a date.
        time_known: the receiver knows that time.
        fix: what kind of position it has.
        motion: that position; where there is no fix it is not to be told.
        tracked: satellites that are received, or as many as have been found yet.
        placed: it is known where they stand.
        used: how many of them make the position, from the first on.
        dops: geometry of those.
        metres_per_dop: what makes an estimated error out of a dilution of precision.
        speed_m_s: estimated error of the speed, standard deviation.
        geoid_m: height of the sea above the ellipsoid.
        leap_seconds: GPS minus UTC.
        first_fix_ms: how long the first fix took; 0 before.
        uptime_ms: since the start.
    """

    gps_ns: int
    utc: Utc
    time_known: bool
    fix: Fix
    motion: Motion
    tracked: tuple[Satellite, ...]
    placed: bool
    used: int
    dops: Dops
    metres_per_dop: float
    speed_m_s: float
    geoid_m: float
    leap_seconds: int
    first_fix_ms: int
    uptime_ms: int

    @property
    def horizontal_m(self) -> float:
        """Estimated error, standard deviation of both horizontal axes together."""
        return self.metres_per_dop * self.dops.horizontal

    @property
    def vertical_m(self) -> float:
        """Estimated error of the height, standard deviation."""
        return self.metres_per_dop * self.dops.vertical
