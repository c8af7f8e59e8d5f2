"""What the suite of the rover's motion reckons by: the law of its wheels, ways on the earth, turns of wheels."""

from __future__ import annotations

import math

import pytest

from hilbench.check import Violation
from hilbench.suites._rover_law import (
    CARRIED_KG_M2,
    FULL_V,
    LIFTED_KG_M2,
    STEP_S,
    Driven,
    settled_rpm,
    volts_at,
    wheel_course,
)
from hilbench.suites._rover_motion import Moment, ideal_turn_deg_s, metres_off, numbers_in
from protocols.pkt import ImuReport, MotionReport, Position
from targets.parts.neo6m.geodesy import Geodetic, Tangent, geodetic_of


def test_at_full_throttle_the_motors_torque_is_the_gears_friction():
    """Worked by hand: 8.4 V - 0.12 ohm x 0.05 A - 1.4 V at the bridge, behind 2 x 1.15 + 4 x 0.12 ohm a motor."""
    speed = settled_rpm(Driven(throttle=1.0)) * math.tau / 60
    friction_nm = 0.0082 + 0.0046 * math.exp(-speed / 2.85)
    current_a = friction_nm / 0.08 * 1.5
    volts = 8.4 - 0.12 * 0.05 - 1.4 - current_a * (2 * 1.15 + 4 * 0.12)
    assert speed == pytest.approx((volts - current_a * 4.0) / 6.0 * 20.9, rel=1e-3)


def test_a_wheel_begins_to_turn_as_its_inertia_lets_it():
    stalled_a = (8.4 - 0.12 * 0.05 - 1.4) / (4.0 + 2 * 1.15 + 4 * 0.12)
    torque_nm = stalled_a / 1.5 * 0.08 - 0.0128
    for inertia in (LIFTED_KG_M2, CARRIED_KG_M2):
        first = next(iter(wheel_course(Driven(throttle=1.0, inertia_kg_m2=inertia), STEP_S)))
        assert first == pytest.approx(torque_nm / inertia * STEP_S, rel=1e-6)
    assert pytest.approx(LIFTED_KG_M2 + 0.0325**2 / 4) == CARRIED_KG_M2


def test_too_little_does_not_turn_a_wheel_and_an_open_circuit_lets_it_run_out():
    assert settled_rpm(Driven(throttle=0.0)) == 0.0
    assert settled_rpm(Driven(throttle=0.15)) < 2.0
    *_, last = wheel_course(Driven(throttle=0.0, start_rpm=100.0), 1.0)
    assert last == 0.0


def test_an_empty_battery_has_less():
    assert volts_at(1.0) == FULL_V == pytest.approx(8.4)
    assert volts_at(0.1) == pytest.approx(6.96)
    assert settled_rpm(Driven(throttle=1.0, emf_v=6.96)) < 0.8 * settled_rpm(Driven(throttle=1.0))


def test_metres_on_the_earth_are_those_of_the_ellipsoid():
    origin = Position(latitude_deg=-34.6175, longitude_deg=-58.3683)
    tangent = Tangent(Geodetic(latitude_deg=-34.6175, longitude_deg=-58.3683, height_m=0.0))
    for east_m, north_m in ((10.0, 0.0), (0.0, -10.0), (3.0, 4.0)):
        place = geodetic_of(tangent.place((east_m, north_m, 0.0)))
        found = metres_off(origin, Position(latitude_deg=place.latitude_deg, longitude_deg=place.longitude_deg))
        assert found == pytest.approx((east_m, north_m), abs=1e-4)


def moment(**others):
    still = {"at_ns": 0, "x_m": 0.0, "y_m": 0.0, "yaw_deg": 0.0, "turn_deg_s": 0.0, "wheels_rad": (0.0,) * 4}
    return Moment(**still | others)


def test_moments():
    start = moment(x_m=1.0, y_m=1.0, yaw_deg=90.0)
    later = moment(at_ns=500_000_000, x_m=1.0, y_m=3.0, wheels_rad=(math.tau, -math.tau, 0.0, math.pi))
    assert later.rpm_since(start) == pytest.approx((120.0, -120.0, 0.0, 60.0))
    assert later.seen_from(start) == pytest.approx((2.0, 0.0))


def test_two_wheels_turn_by_what_their_rims_make():
    """A rim of 1 m/s on each side, against each other, on a track of 140 mm: 14.3 rad/s to the left."""
    rpm = 60 / math.tau / 0.0325
    assert ideal_turn_deg_s((-rpm, rpm, -rpm, rpm)) == pytest.approx(math.degrees(2 / 0.140))


def test_what_is_no_number_is_a_violation():
    sound = MotionReport(rpm=(1.0, 2.0, 3.0, 4.0))
    assert numbers_in(sound) is sound
    for wrong in (ImuReport(quaternion=(math.nan, 0.0, 0.0, 0.0)), MotionReport(rpm=(0.0, math.inf, 0.0, 0.0))):
        with pytest.raises(Violation, match="is no number"):
            numbers_in(wrong)
