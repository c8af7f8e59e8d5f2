"""The car's model: what commands do, where they end, and what no command can do."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.each import each
from tests.share import examples
from worlds.car_commands import CarCommand, CommandMode
from worlds.car_dynamics import CarDynamics
from worlds.car_parameters import DEFAULTS, CarParameters
from worlds.errors import WorldError
from worlds.motion import PlanarPose, PlanarVelocity

HZ = 240
OTHER_STEPS = pytest.mark.exhaustive("the gate has a step on either side of the usual one")
ACKERMANN = CarCommand(mode=CommandMode.ACKERMANN)


def drive(car, command, seconds, hz=HZ):
    car.layer.command = command
    for _ in range(round(seconds * hz)):
        car.advance(1 / hz)
    return car


def at_speed(speed_m_s, **command):
    car = CarDynamics()
    car.adopt(PlanarPose(0.0, 0.0, 0.0), PlanarVelocity(speed_m_s, 0.0, 0.0))
    car.layer.command = CarCommand(mode=CommandMode.ACKERMANN, speed_m_s=speed_m_s, **command)
    return car


def test_a_car_without_commands_stands():
    car = drive(CarDynamics(), CarCommand(), 1.0)
    assert car.pose == (0.0, 0.0, 0.0)
    assert car.velocity == (0.0, 0.0, 0.0)


@each("field", [name for name in CarCommand.__slots__ if name not in {"mode", "hand_brake"}])
@each("value", [math.nan, math.inf])
def test_what_is_not_finite_is_refused(field, value):
    with pytest.raises(WorldError, match="not finite"):
        replace(ACKERMANN, **{field: value})


def test_left_is_left():
    car = drive(CarDynamics(), replace(ACKERMANN, steering_rad=0.1, speed_m_s=5.0), 3.0)
    assert min(car.steering_rad, car.yaw_rate_rad_s, car.pose.y_m, car.pose.yaw_rad) > 0
    car = drive(CarDynamics(), CarCommand(steer=-0.1, throttle=0.3), 3.0)
    assert max(car.steering_rad, car.yaw_rate_rad_s, car.pose.y_m, car.pose.yaw_rad) < 0


@settings(max_examples=examples(25))
@given(
    angle=st.floats(0.02, 0.5),
    speed=st.floats(0.5, 12.0),
    accel=st.floats(0.5, 3.0),
    jerk=st.sampled_from([0.0, 0.5, 4.0]),
)
def test_a_mirrored_command_gives_the_mirrored_way(angle, speed, accel, jerk):
    command = CarCommand(
        mode=CommandMode.ACKERMANN, steering_rad=angle, speed_m_s=speed, accel_m_s2=accel, jerk_m_s3=jerk
    )
    left = drive(CarDynamics(), command, 2.0)
    right = drive(CarDynamics(), replace(command, steering_rad=-angle), 2.0)
    assert right.pose == (left.pose.x_m, -left.pose.y_m, -left.pose.yaw_rad)


def test_the_tyre_angle_has_the_asked_rate_and_the_car_s_limits():
    car = drive(CarDynamics(), replace(ACKERMANN, steering_rad=0.4, steering_rate_rad_s=0.2), 1.0)
    assert car.steering_rad == pytest.approx(0.2)
    drive(car, car.layer.command, 2.0)
    assert car.steering_rad == pytest.approx(0.4, abs=1e-12)
    fast = drive(CarDynamics(), replace(ACKERMANN, steering_rad=9.0, steering_rate_rad_s=99.0), 0.25)
    assert fast.steering_rad == pytest.approx(0.25 * DEFAULTS.max_steering_rate_rad_s)
    assert drive(fast, fast.layer.command, 1.0).steering_rad == pytest.approx(DEFAULTS.max_steering_rad)


def test_full_lock_of_the_wheel_is_the_original_s():
    """-1.0292 rad x CARLA's steer, the mean of 69.99 and 47.95 degrees (Carla-Autoware-Bridge steering_status.py)."""
    assert drive(CarDynamics(), CarCommand(steer=0.5), 1.0).steering_rad == pytest.approx(0.5146, abs=5e-5)


@each("field", ["steering_rate_rad_s", "accel_m_s2", "jerk_m_s3"])
def test_the_magnitude_of_a_limit_counts(field):
    base = replace(ACKERMANN, steering_rad=0.2, speed_m_s=4.0)
    one, other = (drive(CarDynamics(), replace(base, **{field: value}), 1.0) for value in (0.5, -0.5))
    assert one.pose == other.pose


def test_a_speed_below_zero_stops_the_car_and_never_reverses():
    car = at_speed(2.0)
    drive(car, replace(ACKERMANN, speed_m_s=-3.0), 2.0)
    assert car.lon_speed_m_s == 0.0
    assert car.pose.x_m == pytest.approx(2.0**2 / 2 / DEFAULTS.max_decel_m_s2, rel=0.02)


def test_brakes_hold_and_do_not_turn_back():
    car = drive(at_speed(3.0), CarCommand(brake=1.0), 1.0)
    assert (car.lon_speed_m_s, car.lon_accel_m_s2) == (0.0, 0.0)
    assert drive(car, CarCommand(brake=0.5, throttle=0.5), 1.0).lon_speed_m_s == 0.0
    assert drive(car, CarCommand(throttle=0.02), 1.0).lon_speed_m_s == 0.0  # less than rolling resistance
    assert drive(car, CarCommand(throttle=0.1), 1.0).lon_speed_m_s > 0.1


@settings(max_examples=examples(40))
@given(
    speed=st.floats(0.2, 12.0),
    brake=st.floats(0.05, 1.0),
    brakes_s=st.floats(0.0, 1.5),
    then=st.floats(0.1, 12.0),
    accel=st.floats(0.1, 3.0),
    jerk=st.floats(0.1, 20.0),
)
def test_a_car_that_brakes_is_never_sent_backwards_by_a_limit_of_jerk(speed, brake, brakes_s, then, accel, jerk):
    """Brakes let go as slowly as the limit says; what they do on the way is to stop the car."""
    car = at_speed(speed)
    drive(car, CarCommand(brake=brake), brakes_s)
    car.layer.command = CarCommand(mode=CommandMode.ACKERMANN, speed_m_s=then, accel_m_s2=accel, jerk_m_s3=jerk)
    for _ in range(10 * HZ):
        car.advance(1 / HZ)
        assert car.lon_speed_m_s >= 0
    assert car.lon_speed_m_s > 0


def test_pedals_beyond_their_ends_are_at_their_ends():
    for wild, tame in ((CarCommand(throttle=7.0, steer=2.0), CarCommand(throttle=1.0, steer=1.0)),):
        assert drive(CarDynamics(), wild, 1.0).pose == drive(CarDynamics(), tame, 1.0).pose
    assert drive(at_speed(5.0), CarCommand(brake=9.0, throttle=-1.0), 0.3).pose.x_m == pytest.approx(
        drive(at_speed(5.0), CarCommand(brake=1.0), 0.3).pose.x_m
    )


def test_the_hand_brake_holds_the_rear_wheels_only():
    car = drive(at_speed(8.0), CarCommand(hand_brake=True), 0.5)
    expected = DEFAULTS.friction * DEFAULTS.rear_load_n / DEFAULTS.mass_kg + 9.81 * DEFAULTS.rolling_resistance
    assert car.lon_accel_m_s2 == pytest.approx(-expected, rel=0.01)


def test_grip_ends_the_brakes():
    """On ice the wheels give no more than friction has."""
    ice = CarDynamics(CarParameters(friction=0.2))
    ice.adopt(PlanarPose(0.0, 0.0, 0.0), PlanarVelocity(8.0, 0.0, 0.0))
    drive(ice, ACKERMANN, 0.5)
    assert ice.lon_accel_m_s2 == pytest.approx(-0.2 * 9.81 - 9.81 * DEFAULTS.rolling_resistance, rel=0.02)


def test_grip_ends_the_lateral_force():
    """However far the wheel is turned, the sideways acceleration stays below friction times gravity."""
    car = drive(at_speed(15.0), replace(ACKERMANN, speed_m_s=15.0, steering_rad=0.5), 5.0)
    assert 0.6 * 9.81 < car.lon_speed_m_s * car.yaw_rate_rad_s < DEFAULTS.friction * 9.81


def test_full_throttle_to_100_km_h_takes_as_long_as_the_source_says():
    """9.2 s at 3.0 m/s² (carla_control_physics.py), if nothing resisted: rolling and drag cost 0.9 s."""
    car, seconds = CarDynamics(), 0.0
    while car.lon_speed_m_s < 100 / 3.6:
        drive(car, CarCommand(throttle=1.0), 1 / HZ)
        seconds += 1 / HZ
    assert seconds == pytest.approx(10.0, abs=0.2)


def test_power_ends_the_engine_s_force():
    car = drive(at_speed(50.0), CarCommand(throttle=1.0), 1 / HZ)
    drag_n = DEFAULTS.air_density_kg_m3 * DEFAULTS.drag_coefficient * DEFAULTS.drag_area_m2 / 2 * 50.0**2
    expected = (DEFAULTS.power_w / 50.0 - drag_n) / DEFAULTS.mass_kg - 9.81 * DEFAULTS.rolling_resistance
    assert car.lon_accel_m_s2 == pytest.approx(expected, rel=1e-3)


def test_the_hand_brake_helps_a_full_stop_at_its_end():
    """Below 0.1 m/s it comes on as well, and all tyres together give what friction has."""
    end = drive(at_speed(0.09), ACKERMANN, 0.001, 1000)
    assert end.lon_accel_m_s2 == pytest.approx(-9.81 * (DEFAULTS.friction + DEFAULTS.rolling_resistance), rel=1e-3)
    before = drive(at_speed(0.11), ACKERMANN, 0.001, 1000)
    assert before.lon_accel_m_s2 == pytest.approx(-DEFAULTS.max_decel_m_s2, rel=1e-6)


def test_an_obstacle_s_push_is_gone_on_from():
    car = at_speed(4.0)
    car.adopt(PlanarPose(1.0, 2.0, math.pi / 2), PlanarVelocity(-1.0, 0.5, 0.3))
    assert car.pose == (1.0, 2.0, math.pi / 2)
    assert car.velocity == pytest.approx((-1.0, 0.5, 0.3))
    assert (car.lon_speed_m_s, car.lat_speed_m_s) == pytest.approx((0.5, 1.0))


def test_a_sideways_push_dies_away_within_grip():
    car = CarDynamics()
    car.adopt(PlanarPose(0.0, 0.0, 0.0), PlanarVelocity(0.0, 2.0, 0.0))
    car.advance(0.1)
    assert car.lat_speed_m_s >= 2.0 - 0.1 * DEFAULTS.friction * 9.81 - 1e-6
    drive(car, CarCommand(), 2.0)
    assert max(map(abs, car.velocity)) < 1e-6


def test_placing_takes_motion_and_commands_away():
    car = drive(CarDynamics(), CarCommand(throttle=1.0, steer=0.2), 1.0)
    steering = car.steering_rad
    car.place(PlanarPose(1.0, 2.0, 0.5))
    assert (car.pose, car.velocity, car.steering_rad) == ((1.0, 2.0, 0.5), (0.0, 0.0, 0.0), steering)
    assert drive(car, car.layer.command, 0.01).lon_speed_m_s == 0.0


@pytest.mark.parametrize("hz", [50, 480, *(pytest.param(hz, marks=OTHER_STEPS) for hz in (100, 1000))])
def test_the_way_does_not_depend_on_the_step(hz):
    """Over the change from rolling to slipping tyres and back."""
    command = CarCommand(mode=CommandMode.ACKERMANN, steering_rad=0.3, speed_m_s=4.0, accel_m_s2=0.5)
    ends = [drive(drive(CarDynamics(), command, 8.0, rate), ACKERMANN, 2.0, rate) for rate in (HZ, hz)]
    assert math.dist(ends[0].pose[:2], ends[1].pose[:2]) < 5e-5
    assert ends[0].pose.yaw_rad == pytest.approx(ends[1].pose.yaw_rad, abs=1e-9)


def test_what_is_not_modelled_is_said():
    assert any("reverse" in line for line in CarDynamics.ABSENT)
