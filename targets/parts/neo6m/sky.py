"""The satellites above the receiver, and how good their geometry is.

They stand still, evenly spread (choice: orbits are not modelled); the numbers are arbitrary. How much of the sky is
open says how many of them are received: the highest ones are the last that stay.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["SATELLITES", "Dops", "Satellite", "dops_of", "received"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Satellite:
    """One satellite: its number, where it stands, and its carrier to noise density in dBHz."""

    number: int
    elevation_deg: int
    azimuth_deg: int
    cn0_dbhz: int = 0


SATELLITES = tuple(
    Satellite(number=number, elevation_deg=elevation, azimuth_deg=azimuth)
    for number, elevation, azimuth in (
        (17, 78, 40),
        (6, 58, 215),
        (28, 52, 330),
        (19, 44, 120),
        (2, 37, 265),
        (12, 31, 20),
        (24, 26, 170),
        (9, 20, 300),
        (3, 15, 75),
        (31, 10, 230),
    )
)
"""From the highest to the lowest."""

_CN0_HORIZON, _CN0_RISE = 30.0, 18.0
"""30 dBHz at the horizon to 48 dBHz above (assumed), half of it under a closed sky."""


def received(sky: float, min_elevation_deg: float) -> tuple[Satellite, ...]:
    """Return the satellites that are received while a part of the sky, 0..1, is open."""
    count = math.floor(sky * len(SATELLITES) + 0.5)
    return tuple(
        Satellite(
            number=one.number,
            elevation_deg=one.elevation_deg,
            azimuth_deg=one.azimuth_deg,
            cn0_dbhz=round((0.5 + sky / 2) * (_CN0_HORIZON + _CN0_RISE * math.sin(math.radians(one.elevation_deg)))),
        )
        for one in SATELLITES[:count]
        if one.elevation_deg >= min_elevation_deg
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Dops:
    """Dilution of precision to the east, to the north, upwards and in time."""

    east: float
    north: float
    vertical: float
    time: float

    @property
    def horizontal(self) -> float:
        """East and north together."""
        return math.hypot(self.east, self.north)

    @property
    def position(self) -> float:
        """All three axes."""
        return math.hypot(self.horizontal, self.vertical)

    @property
    def geometric(self) -> float:
        """With time."""
        return math.hypot(self.position, self.time)


NONE = Dops(east=99.99, north=99.99, vertical=99.99, time=99.99)
"""Without a fix."""


def dops_of(satellites: Sequence[Satellite], *, flat: bool) -> Dops:
    """Return the dilution of precision of some satellites; `NONE` if there are not enough, or all stand in one line.

    Args:
        satellites: that are used.
        flat: the height is known otherwise, as well as from a satellite overhead (choice).
    """
    rows = [_row(one) for one in satellites]
    if flat:
        rows.append((0.0, 0.0, 1.0, 0.0))
    normal = [[sum(row[i] * row[j] for row in rows) for j in range(4)] for i in range(4)]
    diagonal = _inverse_diagonal(normal)
    if diagonal is None:
        return NONE
    east, north, up, time = (math.sqrt(max(0.0, part)) for part in diagonal)
    return Dops(east=east, north=north, vertical=up, time=time)


def _row(one: Satellite) -> tuple[float, float, float, float]:
    """The direction to a satellite, and 1 for the clock."""
    up, around = math.radians(one.elevation_deg), math.radians(one.azimuth_deg)
    return math.cos(up) * math.sin(around), math.cos(up) * math.cos(around), math.sin(up), 1.0


def _inverse_diagonal(matrix: list[list[float]]) -> list[float] | None:
    """The diagonal of the inverse of a symmetric matrix, by elimination; None if it has none to speak of."""
    size = len(matrix)
    rows = [row + [float(i == j) for j in range(size)] for i, row in enumerate(matrix)]
    for column in range(size):
        pivot = max(range(column, size), key=lambda row: abs(rows[row][column]))
        if abs(rows[pivot][column]) < 1e-6:
            return None
        rows[column], rows[pivot] = rows[pivot], rows[column]
        rows[column] = [value / rows[column][column] for value in rows[column]]
        for row in range(size):
            if row != column:
                factor = rows[row][column]
                rows[row] = [value - factor * other for value, other in zip(rows[row], rows[column], strict=True)]
    return [rows[i][size + i] for i in range(size)]
