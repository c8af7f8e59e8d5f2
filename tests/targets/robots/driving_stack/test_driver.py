"""The driver on a kinematic bicycle: stays on its path, turns to the right side, keeps its limits, stops at the end."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols.autoware import Time
from targets.robots.driving_stack import DriverSettings, Path, PathDriver, Pose, SpeedProfile
from tests.each import each

AT_REST = Pose(x_m=0.0, y_m=0.0, yaw_rad=0.0)


# --- one command


@pytest.mark.parametrize(("offset_m", "turns"), [(2.0, -1), (-2.0, 1)])
def test_off_to_one_side_it_steers_to_the_other(straight, offset_m, turns):
    command = PathDriver(straight).command(Pose(x_m=10.0, y_m=offset_m, yaw_rad=0.0), 5.0)
    assert math.copysign(1, command.steering_tire_angle) == turns


def test_where_right_is_positive_the_sign_is_the_other(straight):
    pose = Pose(x_m=10.0, y_m=2.0, yaw_rad=0.1)
    one = PathDriver(straight).command(pose, 5.0)
    other = PathDriver(straight, DriverSettings(steering_sign=-1)).command(pose, 5.0)
    assert other.steering_tire_angle == -one.steering_tire_angle != 0.0


def test_on_a_circle_the_angle_is_that_of_the_bicycle(circle):
    command = PathDriver(circle).command(AT_REST, 5.0)
    assert command.steering_tire_angle == pytest.approx(math.atan(2.85 / 30), rel=0.02)  # points 1 m apart


@given(st.floats(-5, 5), st.floats(-1.5, 1.5), st.floats(0, 12))
def test_a_mirrored_world_gives_mirrored_commands(y_m, yaw_rad, speed_m_s):
    points = [(0.0, 0.0), (20.0, 3.0), (40.0, -4.0), (60.0, 0.0)]
    one = PathDriver(Path(points)).command(Pose(x_m=5.0, y_m=y_m, yaw_rad=yaw_rad), speed_m_s)
    mirrored = Path([(x, -y) for x, y in points])
    other = PathDriver(mirrored).command(Pose(x_m=5.0, y_m=-y_m, yaw_rad=-yaw_rad), speed_m_s)
    assert other.steering_tire_angle == pytest.approx(-one.steering_tire_angle, abs=1e-9)
    assert other.speed == pytest.approx(one.speed)


@given(st.floats(-50, 50), st.floats(-50, 50), st.floats(-math.pi, math.pi), st.floats(-2, 20))
def test_wherever_it_is_its_commands_are_within_its_limits(x_m, y_m, yaw_rad, speed_m_s):
    limits = DriverSettings()
    path = Path([(0.0, 0.0), (20.0, 3.0), (40.0, -4.0), (60.0, 0.0)])
    command = PathDriver(path, limits).command(Pose(x_m=x_m, y_m=y_m, yaw_rad=yaw_rad), speed_m_s)
    assert abs(command.steering_tire_angle) <= limits.steering_limit_rad
    assert 0.0 <= command.speed <= limits.speed_m_s
    assert limits.least_accel_m_s2 <= abs(command.acceleration) <= max(limits.accel_m_s2, limits.decel_m_s2)
    assert math.copysign(1, command.acceleration) == math.copysign(1, command.speed - speed_m_s)


def test_the_stamp_is_that_given(straight):
    assert PathDriver(straight).command(AT_REST, 0.0, Time(3, 4)).stamp == Time(3, 4)
    assert PathDriver(straight).command(AT_REST, 0.0).stamp == Time()


def test_nobody_drives_without_knowing_where_and_how_fast(straight):
    with pytest.raises(ValueError, match="nobody can drive"):
        PathDriver(straight).command(AT_REST, math.nan)
    with pytest.raises(ValueError, match="nobody can drive"):
        PathDriver(straight).command(Pose(x_m=math.inf, y_m=0.0, yaw_rad=0.0), 1.0)


@each("wrong", [{"steering_sign": 0}, {"speed_m_s": 0.0}, {"wheelbase_m": math.nan}])
def test_senseless_settings_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        DriverSettings(**wrong)


# --- closed loops


def test_from_beside_the_path_it_comes_back_to_it(drive, straight):
    loop = drive(straight, y_m=3.0, yaw_rad=0.3)
    loop.run(20.0)
    assert abs(loop.offsets_m[-1]) < 0.01
    assert min(loop.offsets_m) > -0.3  # without swinging far over it


def test_a_circle_is_driven_at_the_speed_that_its_radius_allows(drive, circle):
    loop = drive(circle)
    loop.run(40.0)
    steady = loop.speeds_m_s[-2000:]
    assert min(steady) == pytest.approx(math.sqrt(2.0 * 30), rel=0.01)
    assert max(steady) == pytest.approx(math.sqrt(2.0 * 30), rel=0.01)
    assert max(map(abs, loop.offsets_m)) < 0.1


def test_a_lap_of_the_oval(drive, oval):
    loop = drive(oval)
    lap_s = loop.run(120.0, until=lambda: loop.driver.travelled_m >= oval.length_m)
    slowest_s = oval.length_m / loop.driver.profile.least_m_s
    assert oval.length_m / 10.0 < lap_s < slowest_s + 5.0
    assert max(map(abs, loop.offsets_m)) < 0.35
    assert max(map(abs, loop.lateral_m_s2)) < 1.15 * 2.0
    assert max(loop.speeds_m_s) <= 10.0 + 1e-9


def test_at_the_end_of_an_open_path_it_stands(drive, straight):
    loop = drive(straight)
    loop.run(60.0, until=lambda: loop.driver.arrived and loop.bicycle.speed_m_s == 0.0)
    assert loop.bicycle.speed_m_s == 0.0
    assert 299.5 < loop.bicycle.x_m < 300.2
    assert loop.commands[-1].speed == 0.0
    slowing = [b - a for a, b in pairwise(loop.speeds_m_s) if b < a]
    assert min(slowing[:-30]) > -1.6 * 0.01  # but for the very end, as gently as it was told


def test_a_wrong_wheelbase_costs_accuracy_but_not_the_path(drive, oval):
    right, wrong = drive(oval), drive(oval, DriverSettings(wheelbase_m=2.0))
    right.run(70.0)
    wrong.run(70.0)
    assert 1.5 * max(map(abs, right.offsets_m)) < max(map(abs, wrong.offsets_m)) < 2.0


def test_the_wrong_sign_loses_the_path(drive, circle):
    loop = drive(circle, DriverSettings(steering_sign=-1))
    loop.run(15.0)
    assert max(map(abs, loop.offsets_m)) > 10.0


def test_laps_are_counted(drive, circle):
    loop = drive(circle)
    loop.run(120.0, until=lambda: loop.driver.travelled_m >= 1.5 * circle.length_m)
    assert loop.driver.place.s_m == pytest.approx(0.5 * circle.length_m, abs=1.0)
    assert not loop.driver.arrived


# --- speeds


def test_the_profile_slows_down_in_time_and_gains_speed_after(oval):
    limits = DriverSettings()
    profile = SpeedProfile(oval, limits)
    curve_m_s = math.sqrt(limits.lateral_m_s2 * 25.0)
    assert profile.least_m_s == pytest.approx(curve_m_s, rel=0.02)
    speeds = [profile.speed_m_s(s) for s in range(int(oval.length_m) + 1)]
    assert max(speeds) == limits.speed_m_s
    for one, other in pairwise(speeds):
        assert -2 * limits.decel_m_s2 - 0.05 <= other**2 - one**2 <= 2 * limits.accel_m_s2 + 0.05  # interpolated
    assert profile.speed_m_s(-3.0) == pytest.approx(profile.speed_m_s(oval.length_m - 3.0))


def test_the_profile_of_an_open_path_ends_at_rest(straight):
    profile = SpeedProfile(straight, DriverSettings())
    assert profile.speed_m_s(0.0) == 10.0
    assert profile.speed_m_s(300.0) == 0.0
    assert profile.speed_m_s(290.0) == pytest.approx(math.sqrt(2 * 1.5 * 10.0), rel=0.01)
