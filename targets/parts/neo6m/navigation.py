"""Makes solutions: from where the antenna is, what it receives, and what is set."""

from __future__ import annotations

import math
from collections.abc import Mapping

from targets.parts.neo6m.acquisition import LEAST_SATELLITES, Acquisition
from targets.parts.neo6m.configuration import Nav5
from targets.parts.neo6m.geodesy import Geodetic, Tangent, Vector, geodetic_of
from targets.parts.neo6m.gps_time import gps_of_utc, utc_of_gps
from targets.parts.neo6m.settings import Neo6mSettings
from targets.parts.neo6m.sky import NONE, SATELLITES, Dops, Satellite, dops_of, received
from targets.parts.neo6m.solution import Fix, Motion, Solution
from targets.parts.neo6m.wander import MEDIAN, Wander
from targets.parts.track import Track

__all__ = ["Navigation"]

_FOR_3D = 4
_ONLY_2D, _ONLY_3D = 1, 2
_KEPT_NS = 1_000_000_000
_PLACES, _SPEEDS = ("x", "y", "z"), ("vx", "vy", "vz")


class Navigation:
    """See the module.

    Args:
        settings: of the receiver.
        seed: of everything random in it.

    Attributes:
        acquisition: how far the search is.
        sky: which part of the sky is open, 0..1.
    """

    def __init__(self, settings: Neo6mSettings, seed: int) -> None:
        self._settings = settings
        self._start_ns = gps_of_utc(settings.utc, settings.leap_seconds)
        self._tangent = Tangent(
            Geodetic(
                latitude_deg=settings.latitude_deg, longitude_deg=settings.longitude_deg, height_m=settings.height_m
            )
        )
        bearing = math.radians(settings.x_axis_bearing_deg)
        self._bearing = math.cos(bearing), math.sin(bearing)
        self._place = Track((0.0, 0.0, 0.0))
        self._speed = Track((0.0, 0.0, 0.0))
        self._wander = Wander(settings, seed)
        self._course_deg = 0.0
        self._open = dops_of(SATELLITES, flat=False)
        self.acquisition = Acquisition(settings, seed)
        self.sky = 1.0

    def step(self, from_ns: int, to_ns: int, before: Mapping[str, float], after: Mapping[str, float]) -> None:
        """Take a physics step; see `Track.follow`."""
        for track, names in ((self._place, _PLACES), (self._speed, _SPEEDS)):
            track.follow(from_ns, to_ns, before, after, names)
            track.forget(from_ns - _KEPT_NS)

    def gps_ns(self, now_ns: int) -> int:
        """GPS time of a bench time."""
        return self._start_ns + now_ns

    def next_epoch_ns(self, after_ns: int, period_ms: int) -> int:
        """The first moment after a bench time at which GPS time is a whole number of periods."""
        period_ns = period_ms * 1_000_000
        return ((self._start_ns + after_ns) // period_ns + 1) * period_ns - self._start_ns

    def solve(self, now_ns: int, started_ns: int, nav5: Nav5) -> Solution:
        """Make the next solution."""
        settings = self._settings
        seen = received(self.sky, nav5.min_elevation_deg)
        self.acquisition.step(len(seen), now_ns)
        self._wander.step(now_ns)
        fix, dops = self._fix(seen, nav5)
        found = self.acquisition.found
        tracked = seen if found else seen[: math.floor(len(seen) * self.acquisition.progress)]
        return Solution(
            gps_ns=self.gps_ns(now_ns),
            utc=utc_of_gps(self.gps_ns(now_ns), settings.leap_seconds),
            time_known=self.acquisition.time_known,
            fix=fix,
            motion=self._motion(now_ns, dops if fix else NONE),
            tracked=tracked,
            placed=self.acquisition.placed,
            used=len(seen) if fix else 0,
            dops=dops if fix else NONE,
            metres_per_dop=self._metres_per_dop(),
            speed_m_s=settings.velocity_m_s / MEDIAN * math.sqrt(3),
            geoid_m=settings.geoid_m,
            leap_seconds=settings.leap_seconds,
            first_fix_ms=self.acquisition.first_fix_ms,
            uptime_ms=(now_ns - started_ns) // 1_000_000,
        )

    def _fix(self, seen: tuple[Satellite, ...], nav5: Nav5) -> tuple[Fix, Dops]:
        """The kind of fix, and the geometry; a position that is worse than the mask of CFG-NAV5 is none."""
        if not self.acquisition.found or len(seen) < LEAST_SATELLITES:
            return Fix.NONE, NONE
        flat = len(seen) < _FOR_3D or nav5.fix_mode == _ONLY_2D
        dops = dops_of(seen, flat=flat)
        if (flat and nav5.fix_mode == _ONLY_3D) or dops.position > nav5.position_dop_tenths / 10:
            return Fix.NONE, dops
        return (Fix.FIX_2D if flat else Fix.FIX_3D), dops

    def _metres_per_dop(self) -> float:
        """What makes the error under an open sky that of the data sheet."""
        return self._settings.accuracy_m / MEDIAN * math.sqrt(2) / self._open.horizontal

    def _motion(self, now_ns: int, dops: Dops) -> Motion:
        axis_m = self._metres_per_dop() * dops.horizontal / math.sqrt(2)
        error_m = self._wander.position_m(axis_m, axis_m, self._metres_per_dop() * dops.vertical)
        ecef_m = self._tangent.place(_sum(self._enu(self._place.unfiltered_at(now_ns)), error_m))
        here = geodetic_of(ecef_m)
        local = Tangent(here)
        true_m_s = self._tangent.direction(self._enu(self._speed.unfiltered_at(now_ns)))
        enu_m_s = _sum(local.components(true_m_s), self._wander.velocity_m_s)
        frozen = math.hypot(*enu_m_s[:2]) < self._settings.course_from_m_s
        if not frozen:
            self._course_deg = math.degrees(math.atan2(enu_m_s[0], enu_m_s[1])) % 360
        return Motion(
            place=here,
            ecef_m=ecef_m,
            enu_m_s=enu_m_s,
            ecef_m_s=local.direction(enu_m_s),
            course_deg=self._course_deg,
            course_frozen=frozen,
        )

    def _enu(self, world: tuple[float, ...]) -> Vector:
        """A vector of the world, whose x axis has a bearing and whose y axis lies to the left of it."""
        x, y, z = world
        north, east = self._bearing
        return x * east - y * north, x * north + y * east, z


def _sum(one: Vector, other: Vector) -> Vector:
    return one[0] + other[0], one[1] + other[1], one[2] + other[2]
