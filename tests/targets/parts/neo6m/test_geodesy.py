"""The way from the flat world to the ellipsoid, the calendar, and the geometry of satellites."""

from __future__ import annotations

import math
from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.parts.neo6m.geodesy import Geodetic, Tangent, ecef_of, geodetic_of
from targets.parts.neo6m.gps_time import gps_of_utc, time_of_week_ms, utc_of_gps, week_of
from targets.parts.neo6m.sky import NONE, SATELLITES, Satellite, dops_of, received
from tests.each import each

A, F = 6378137.0, 1 / 298.257223563
E2 = F * (2 - F)


def _place(latitude, longitude, height) -> Geodetic:
    return Geodetic(latitude_deg=latitude, longitude_deg=longitude, height_m=height)


@each(
    ("place", "ecef"),
    [
        ((0, 0, 0), (6378137.0, 0, 0)),
        ((0, 90, 100), (0, 6378237.0, 0)),
        ((90, 0, 0), (0, 0, 6356752.314245)),
        ((-90, 0, 10), (0, 0, -6356762.314245)),
    ],
)
def test_the_axes_of_the_ellipsoid(place, ecef) -> None:
    assert ecef_of(_place(*place)) == pytest.approx(ecef, abs=1e-6)


@given(st.floats(-90, 90), st.floats(-180, 180), st.floats(-400, 20_000))
def test_there_and_back(latitude, longitude, height) -> None:
    back = geodetic_of(ecef_of(_place(latitude, longitude, height)))
    assert back.height_m == pytest.approx(height, abs=1e-6)
    assert back.latitude_deg == pytest.approx(latitude, abs=1e-11)
    around = (back.longitude_deg - longitude + 180) % 360 - 180
    assert around * math.cos(math.radians(latitude)) == pytest.approx(0, abs=1e-11)


@each("latitude", [-34.6175, 0.0, 47.3, 70.0])
def test_a_hundred_metres_along_the_radii_of_curvature(latitude) -> None:
    """Near the origin a metre is an arc of the meridian's radius to the north and of the normal's to the east."""
    tangent = Tangent(_place(latitude, -58.3683, 36))
    sine = math.sin(math.radians(latitude))
    meridian = A * (1 - E2) / (1 - E2 * sine**2) ** 1.5 + 36
    normal = A / math.sqrt(1 - E2 * sine**2) + 36
    there = geodetic_of(tangent.place((30.0, 40.0, 0.0)))
    north_m = math.radians(there.latitude_deg - latitude) * meridian
    east_m = math.radians(there.longitude_deg + 58.3683) * normal * math.cos(math.radians(latitude))
    assert (east_m, north_m) == pytest.approx((30, 40), abs=1e-3)
    assert there.height_m - 36 == pytest.approx(50**2 / (2 * A), abs=1e-5)


def test_a_kilometre_is_a_kilometre() -> None:
    """The chord is exact; up is the normal of the ellipsoid."""
    origin = _place(-34.6175, -58.3683, 36)
    tangent = Tangent(origin)
    for enu in ((1000.0, 0, 0), (0, 1000.0, 0), (600.0, -800.0, 0)):
        assert math.dist(ecef_of(origin), tangent.place(enu)) == pytest.approx(1000, abs=1e-6)
        assert tangent.components(tangent.direction(enu)) == pytest.approx(enu, abs=1e-9)
    above = geodetic_of(tangent.place((0, 0, 25.0)))
    assert above == _place(
        pytest.approx(-34.6175, abs=1e-11), pytest.approx(-58.3683, abs=1e-11), pytest.approx(61, abs=1e-6)
    )


# --- time


EPOCH = datetime(1980, 1, 6, tzinfo=UTC)


@given(st.integers(0, 10**10))
def test_the_calendar_is_that_of_the_standard_library(seconds) -> None:
    moment = EPOCH + timedelta(seconds=seconds)
    gps_ns = gps_of_utc(moment.isoformat()[:19], 18)
    assert gps_ns == (seconds + 18) * 10**9
    back = utc_of_gps(gps_ns, 18)
    assert datetime(back.year, back.month, back.day, back.hour, back.minute, back.second, tzinfo=UTC) == moment


def test_week_and_time_of_week() -> None:
    """Friday noon, and 18 leap seconds."""
    gps_ns = gps_of_utc("2021-09-10T12:00:00.25", 18)
    assert week_of(gps_ns) == 2174
    assert time_of_week_ms(gps_ns) == (5 * 86400 + 12 * 3600 + 18) * 1000 + 250
    assert utc_of_gps(gps_ns, 18).nano == 250_000_000


@each("wrong", ["", "yesterday", "2021-02-29T00:00:00", "2021-01-01T24:00:00", "1979-01-01T00:00:00"])
def test_what_is_no_moment(wrong) -> None:
    with pytest.raises(ValueError, match=r"2021-09-10T12:00:00|no moment"):
        gps_of_utc(wrong, 18)


# --- geometry


def _standing(*where) -> list[Satellite]:
    return [Satellite(number=1, elevation_deg=up, azimuth_deg=around) for up, around in where]


def test_dilution_of_a_regular_geometry() -> None:
    """One overhead and four around the horizon: G'G is diag(2, 2, 1, 5) with 1 between up and time."""
    dops = dops_of(_standing((90, 0), (0, 0), (0, 90), (0, 180), (0, 270)), flat=False)
    assert dops.east == pytest.approx(math.sqrt(1 / 2))
    assert dops.north == pytest.approx(math.sqrt(1 / 2))
    assert dops.vertical == pytest.approx(math.sqrt(5 / 4))
    assert dops.time == pytest.approx(math.sqrt(1 / 4))
    assert dops.horizontal == pytest.approx(1)
    assert dops.position == pytest.approx(1.5)
    assert dops.geometric == pytest.approx(math.sqrt(2.5))


def test_too_few_satellites_have_no_geometry() -> None:
    assert dops_of(_standing((30, 0), (40, 120), (50, 240)), flat=False) == NONE
    assert dops_of(_standing((30, 0), (30, 0), (30, 0), (30, 0)), flat=False) == NONE
    assert dops_of(_standing((30, 0), (40, 120), (50, 240)), flat=True).horizontal < 3


def test_a_known_height_stands_for_a_satellite_overhead() -> None:
    """Three around the horizon: G'G is diag(3/2, 3/2, 1, 3)."""
    dops = dops_of(_standing((0, 0), (0, 120), (0, 240)), flat=True)
    assert (dops.east, dops.north) == pytest.approx((math.sqrt(2 / 3), math.sqrt(2 / 3)))
    assert (dops.vertical, dops.time) == pytest.approx((1, math.sqrt(1 / 3)))


@given(st.floats(0, 1))
def test_the_more_sky_the_more_satellites(sky) -> None:
    seen = received(sky, 5)
    assert abs(len(seen) - sky * len(SATELLITES)) <= 0.5
    assert [one.number for one in seen] == [one.number for one in SATELLITES[: len(seen)]]
    assert all(0 < one.cn0_dbhz <= 48 for one in seen)


def test_an_open_sky_is_a_good_one_and_low_satellites_can_be_masked() -> None:
    assert dops_of(received(1, 5), flat=False).position < 2
    assert len(received(1, 30)) == 6
