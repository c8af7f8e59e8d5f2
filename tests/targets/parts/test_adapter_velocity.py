"""Motor codes to velocities: the published table for all 64 codes, and each way to leave it."""

from __future__ import annotations

import itertools
import math

import pytest

from targets.parts.p2os_adapter import P2osAdapterSettings, Velocity, velocity_of_codes, wire_speeds
from tests.each import each

CODES = range(-4, 4)
PUBLISHED = P2osAdapterSettings()

SPEED_MM_S = dict(
    zip(range(-8, 7), (-250, -219, -187, -156, -125, -94, -62, -31, 0, 31, 62, 93, 125, 156, 187), strict=True)
)
"""By the sum of both codes (bluepill_comm.cpp, in C arithmetic)."""
TURN_MRAD_S = dict(
    zip(range(-7, 8), (-149, -127, -106, -85, -64, -42, -21, 0, 21, 42, 63, 85, 106, 127, 148), strict=True)
)
"""By the difference right - left."""
TURN_DEG_S = dict(zip(range(-7, 8), (-9, -7, -6, -5, -4, -2, -1, 0, 1, 2, 4, 5, 6, 7, 8), strict=True))
"""What goes to the robot for it."""


def test_all_codes_as_published() -> None:
    for left, right in itertools.product(CODES, repeat=2):
        velocity = velocity_of_codes(left, right, PUBLISHED)
        assert velocity == (SPEED_MM_S[left + right] / 1000, TURN_MRAD_S[right - left] / 1000), (left, right)
        speeds = wire_speeds(velocity, PUBLISHED)
        assert speeds == (SPEED_MM_S[left + right], TURN_DEG_S[right - left]), (left, right)


def test_without_integer_arithmetic_the_scale_is_straight() -> None:
    exact = P2osAdapterSettings(integer_arithmetic=False)
    for left, right in itertools.product(CODES, repeat=2):
        speed_m_s, turn_rad_s = velocity_of_codes(left, right, exact)
        assert speed_m_s == pytest.approx((left + right) * 0.03125), (left, right)
        assert turn_rad_s == pytest.approx((right - left) * 0.02125), (left, right)
        published = velocity_of_codes(left, right, PUBLISHED)
        assert abs(speed_m_s - published.speed_m_s) < 0.001, (left, right)
        assert abs(turn_rad_s - published.turn_rad_s) <= 0.001, (left, right)
        speed_mm_s, _ = wire_speeds(Velocity(speed_m_s, turn_rad_s), exact)
        assert abs(speed_mm_s - (left + right) * 31.25) <= 0.5, (left, right)


def test_integer_arithmetic_shows() -> None:
    exact = P2osAdapterSettings(integer_arithmetic=False)
    assert velocity_of_codes(3, 3, PUBLISHED).speed_m_s == 0.187
    assert velocity_of_codes(3, 3, exact).speed_m_s == 0.1875
    assert wire_speeds(velocity_of_codes(3, 3, exact), exact) == (188, 0)


@each("integer", [True, False])
@each("difference", range(1, 8))
def test_published_turning_is_eight_times_slower_than_two_wheels(difference, integer) -> None:
    left = -difference // 2
    right = left + difference
    published, differential = (
        velocity_of_codes(left, right, P2osAdapterSettings(turning=turning, integer_arithmetic=integer))
        for turning in ("published", "differential")
    )
    assert differential.turn_rad_s == pytest.approx(difference * 0.0625 / 0.35714, abs=0.001)
    assert differential.turn_rad_s / published.turn_rad_s == pytest.approx(8.24, abs=0.2)
    assert differential.speed_m_s == published.speed_m_s


def test_g20_turn_on_the_spot() -> None:
    assert velocity_of_codes(-1, 1, PUBLISHED) == (0.0, 0.042)
    differential = P2osAdapterSettings(turning="differential")
    assert velocity_of_codes(-1, 1, differential) == (0.0, 0.35)
    assert wire_speeds(velocity_of_codes(-1, 1, differential), differential) == (0, 20)


def test_limits_of_the_library() -> None:
    assert wire_speeds(Velocity(0.75, math.radians(200)), PUBLISHED) == (500, 100)
    assert wire_speeds(Velocity(-0.75, -math.radians(200)), PUBLISHED) == (-500, -100)


def test_other_scales() -> None:
    half = P2osAdapterSettings(speed_range_mm_s=250, turn_range_mrad_s=170)
    assert velocity_of_codes(3, 3, half) == (0.093, 0.0)
    assert velocity_of_codes(-4, 3, half).turn_rad_s == 0.074
