"""From the flat world of a bench to the ellipsoid: a local tangent plane, ECEF, latitude and longitude (WGS 84).

The world's z axis is the normal of the ellipsoid at the origin; its x axis has a bearing, y lies to the left of it.
With east e, north n, up u at the origin of latitude p and longitude l:

X = X0 - sin l e - sin p cos l n + cos p cos l u Y = Y0 + cos l e - sin p sin l n + cos p sin l u Z = Z0 + cos p n +
sin p u

X0 = (N + h) cos p cos l, Y0 = (N + h) cos p sin l, Z0 = (N (1 - e2) + h) sin p, N = a / sqrt(1 - e2 sin2 p)

Nothing is approximated on the way there. Back to latitude and height Bowring's formula starts an iteration that ends
far below a millimetre (B. R. Bowring, Survey Review 23, 1976; NIMA TR8350.2 has the ellipsoid).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

__all__ = ["Geodetic", "Tangent", "ecef_of", "geodetic_of"]

_A_M = 6_378_137.0
_F = 1 / 298.257223563
_E2 = _F * (2 - _F)
_B_M = _A_M * (1 - _F)
_ROUNDS = 3

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Geodetic:
    """A place; the height is above the ellipsoid."""

    latitude_deg: float
    longitude_deg: float
    height_m: float


def ecef_of(place: Geodetic) -> Vector:
    """Return X, Y, Z in m."""
    lat, lon = math.radians(place.latitude_deg), math.radians(place.longitude_deg)
    normal_m = _A_M / math.sqrt(1 - _E2 * math.sin(lat) ** 2)
    ring_m = (normal_m + place.height_m) * math.cos(lat)
    return ring_m * math.cos(lon), ring_m * math.sin(lon), (normal_m * (1 - _E2) + place.height_m) * math.sin(lat)


def geodetic_of(ecef_m: Vector) -> Geodetic:
    """Return the place of X, Y, Z in m; anywhere but near the centre of the earth."""
    x, y, z = ecef_m
    ring_m = math.hypot(x, y)
    reduced = math.atan2(z * _A_M, ring_m * _B_M)
    lat = 0.0
    for _ in range(_ROUNDS):
        up = z + _E2 / (1 - _E2) * _B_M * math.sin(reduced) ** 3
        lat = math.atan2(up, ring_m - _E2 * _A_M * math.cos(reduced) ** 3)
        reduced = math.atan2((1 - _F) * math.sin(lat), math.cos(lat))
    normal_m = _A_M / math.sqrt(1 - _E2 * math.sin(lat) ** 2)
    height_m = ring_m * math.cos(lat) + z * math.sin(lat) - _A_M**2 / normal_m
    return Geodetic(latitude_deg=math.degrees(lat), longitude_deg=math.degrees(math.atan2(y, x)), height_m=height_m)


class Tangent:
    """The axes east, north and up at a place.

    Args:
        place: where.
    """

    def __init__(self, place: Geodetic) -> None:
        lat, lon = math.radians(place.latitude_deg), math.radians(place.longitude_deg)
        self._place_m = ecef_of(place)
        self._axes: tuple[Vector, Vector, Vector] = (
            (-math.sin(lon), math.cos(lon), 0.0),
            (-math.sin(lat) * math.cos(lon), -math.sin(lat) * math.sin(lon), math.cos(lat)),
            (math.cos(lat) * math.cos(lon), math.cos(lat) * math.sin(lon), math.sin(lat)),
        )

    def place(self, enu_m: Vector) -> Vector:
        """Return ECEF of a place that is so far east, north and up."""
        x, y, z = self.direction(enu_m)
        x0, y0, z0 = self._place_m
        return x0 + x, y0 + y, z0 + z

    def direction(self, enu: Vector) -> Vector:
        """Return a vector in ECEF, without the place."""
        east, north, up = self._axes
        e, n, u = enu
        return tuple(e * a + n * b + u * c for a, b, c in zip(east, north, up, strict=True))  # type: ignore[return-value]

    def components(self, ecef: Vector) -> Vector:
        """Return a vector's parts to the east, to the north and up."""
        return tuple(sum(a * b for a, b in zip(axis, ecef, strict=True)) for axis in self._axes)  # type: ignore[return-value]
