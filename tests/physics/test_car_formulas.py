"""The car's model against formulas: circles, limits of acceleration and jerk, ways to stop, coasting.

The figures in the comments are what was measured; `docs/vehicle-car.md` has them as a table.
"""

from __future__ import annotations

import itertools
import math

import pytest

from tests.each import each
from worlds.car_commands import CarCommand, CommandMode
from worlds.car_dynamics import CarDynamics
from worlds.car_parameters import DEFAULTS as P
from worlds.motion import PlanarPose, PlanarVelocity

HZ = 240
BETWEEN = pytest.mark.exhaustive("the gate has the formula at other values, at the ends of what holds")


def ackermann(**fields):
    return CarCommand(mode=CommandMode.ACKERMANN, **fields)


def moving(speed_m_s, command):
    car = CarDynamics()
    car.adopt(PlanarPose(0.0, 0.0, 0.0), PlanarVelocity(speed_m_s, 0.0, 0.0))
    car.layer.command = command
    return car


def run(car, seconds):
    """Advance, and return speed and acceleration after each step."""
    rows = []
    for _ in range(round(seconds * HZ)):
        car.advance(1 / HZ)
        rows.append((car.lon_speed_m_s, car.lon_accel_m_s2))
    return rows


def understeer():
    """K of r = v delta / (L + K v^2), in s^2/m (Rajamani, 3.3)."""
    return (
        P.mass_kg / P.wheelbase_m * (P.com_ahead_m / P.front_stiffness_n_rad - P.front_arm_m / P.rear_stiffness_n_rad)
    )


def fitted_radius_m(car, seconds):
    """Radius of the circle through three places of the reference point, a third of the time apart."""
    places = []
    for _ in range(3):
        run(car, seconds / 3)
        places.append(car.pose[:2])
    (ax, ay), (bx, by), (cx, cy) = places
    doubled_area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    sides = math.dist(places[0], places[1]) * math.dist(places[1], places[2]) * math.dist(places[0], places[2])
    return sides / abs(2 * doubled_area)


@pytest.mark.parametrize(
    ("speed_m_s", "angle_deg", "worst"),
    [
        pytest.param(10, 1, 4e-5, marks=BETWEEN),
        pytest.param(10, 2, 1e-4, marks=BETWEEN),
        (10, 5, 5e-4),
        pytest.param(20, 1, 2e-4, marks=BETWEEN),
        (20, 2, 5e-4),
        (5, 2, 5e-4),
    ],
)
def test_a_steady_circle_is_that_of_the_linear_bicycle(speed_m_s, angle_deg, worst):
    """The formula takes angles for their sines, so the error grows with their squares: 0.002 % to 0.16 %."""
    angle = math.radians(angle_deg)
    car = moving(speed_m_s, ackermann(speed_m_s=speed_m_s, steering_rad=angle))
    run(car, 10.0)
    expected = speed_m_s * angle / (P.wheelbase_m + understeer() * speed_m_s**2)
    assert car.yaw_rate_rad_s == pytest.approx(expected, rel=worst)
    assert car.lon_speed_m_s == pytest.approx(speed_m_s, abs=1e-9)
    rear_slip = P.mass_kg * P.front_arm_m * speed_m_s * expected / P.wheelbase_m / P.rear_stiffness_n_rad
    assert car.lat_speed_m_s == pytest.approx(-speed_m_s * rear_slip, rel=0.01)


@each(("speed_m_s", "angle_deg"), [(0.5, 5), (0.9, 20), (0.9, 50)])
def test_a_slow_circle_is_that_of_the_kinematic_bicycle(speed_m_s, angle_deg):
    """Exactly, as that is what the model is there: radius of the rear axle L / tan(delta)."""
    angle = math.radians(angle_deg)
    car = moving(speed_m_s, ackermann(speed_m_s=speed_m_s, steering_rad=angle))
    run(car, 3.0)
    assert car.yaw_rate_rad_s == pytest.approx(speed_m_s * math.tan(angle) / P.wheelbase_m, rel=1e-9)
    assert car.lat_speed_m_s == pytest.approx(0.0, abs=1e-9)
    assert fitted_radius_m(car, 6.0) == pytest.approx(P.wheelbase_m / math.tan(angle), rel=1e-6)


def test_rolling_tyres_follow_the_wheel_without_delay():
    """v tan(delta) / L at each step while the wheel turns, as nothing slips."""
    car = moving(0.8, ackermann(speed_m_s=0.8, steering_rad=0.9, steering_rate_rad_s=0.3))
    for _ in range(2 * HZ):
        car.advance(1 / HZ)
        assert car.yaw_rate_rad_s == pytest.approx(0.8 * math.tan(car.steering_rad) / P.wheelbase_m, abs=1e-7)


def test_between_rolling_and_slipping_lies_something_between():
    angle = math.radians(10)
    shares = []
    for speed in (1.2, 1.5, 1.8):
        car = moving(speed, ackermann(speed_m_s=speed, steering_rad=angle))
        run(car, 5.0)
        kinematic = speed * math.tan(angle) / P.wheelbase_m
        dynamic = kinematic / (1 + understeer() * speed**2 / P.wheelbase_m)
        shares.append((kinematic - car.yaw_rate_rad_s) / (kinematic - dynamic))
    assert 0.0 < shares[0] < shares[1] < shares[2] < 1.2


def test_cornering_costs_speed():
    """Free pedals at 10 m/s and 3 degrees: what the front tyres push back, and what the slip of the car turns away."""
    speed, angle = 10.0, math.radians(3)
    car = moving(speed, ackermann(speed_m_s=speed, steering_rad=angle))
    run(car, 5.0)
    turning = car.yaw_rate_rad_s
    front = P.mass_kg * P.com_ahead_m / P.wheelbase_m * speed * turning
    sideways = car.lat_speed_m_s + P.com_ahead_m * turning
    resistance = 9.81 * P.rolling_resistance
    resistance += P.air_density_kg_m3 * P.drag_coefficient * P.drag_area_m2 / 2 / P.mass_kg * speed**2
    car.layer.command = CarCommand(steer=angle / P.max_steering_rad)
    run(car, 1 / HZ)
    expected = turning * sideways - front * math.tan(angle) / P.mass_kg - resistance
    assert expected < -resistance - 0.02
    assert car.lon_accel_m_s2 == pytest.approx(expected, rel=0.01)


def test_the_integration_is_of_fourth_order():
    """Half the step, a sixteenth of the error; of a car that swings after a push at 15 m/s."""

    def end(hz):
        car = moving(15.0, ackermann(speed_m_s=15.0))
        car.adopt(PlanarPose(0.0, 0.0, 0.0), PlanarVelocity(15.0, 0.5, 0.2))
        for _ in range(round(hz * 0.4)):
            car.advance(1 / hz)
        return car.pose

    exact = end(16000)
    errors = [math.dist(end(hz)[:2], exact[:2]) for hz in (200, 400)]
    assert errors[0] < 1e-6
    assert 10 < errors[0] / errors[1] < 22


def test_the_way_round_is_the_circle_of_speed_over_turn_rate():
    car = moving(10.0, ackermann(speed_m_s=10.0, steering_rad=math.radians(2)))
    run(car, 10.0)
    radius = math.hypot(car.lon_speed_m_s, car.lat_speed_m_s) / car.yaw_rate_rad_s
    assert fitted_radius_m(car, 20.0) == pytest.approx(radius, rel=1e-6)


def test_dynamic_turns_into_kinematic_as_the_car_slows_down():
    """From 3 m/s to 0.5 m/s at 0.5 m/s², full of both: the turn rate stays between the two and has no step."""
    angle = math.radians(10)
    car = moving(3.0, ackermann(speed_m_s=3.0, steering_rad=angle))
    run(car, 3.0)
    car.layer.command = ackermann(speed_m_s=0.5, accel_m_s2=0.5, steering_rad=angle)
    before = car.yaw_rate_rad_s
    for _ in range(6 * HZ):
        car.advance(1 / HZ)
        speed = car.lon_speed_m_s
        kinematic = speed * math.tan(angle) / P.wheelbase_m
        dynamic = speed * math.tan(angle) / (P.wheelbase_m + understeer() * speed**2)
        assert dynamic * 0.995 < car.yaw_rate_rad_s < kinematic * 1.005
        assert abs(car.yaw_rate_rad_s - before) * HZ < 1.5 * 0.5 * math.tan(angle) / P.wheelbase_m
        before = car.yaw_rate_rad_s


@pytest.mark.parametrize("accel", [pytest.param(0.3, marks=BETWEEN), 1.0, 2.5])
def test_a_limited_acceleration_is_exact_and_so_is_the_speed(accel):
    car = moving(0.0, ackermann(speed_m_s=8.3, accel_m_s2=accel))
    rows = run(car, 8.3 / accel + 1)
    accels = [a for _, a in rows]
    assert max(accels) == pytest.approx(accel, rel=1e-9)
    assert max(speed for speed, _ in rows) == rows[-1][0] == pytest.approx(8.3, abs=1e-12)
    assert sum(a > 0 for a in accels) / HZ == pytest.approx(8.3 / accel, abs=1 / HZ)


@pytest.mark.parametrize(
    ("jerk", "accel"),
    [(0.7, 1.5), pytest.param(1.0, 1.5, marks=BETWEEN), pytest.param(2.5, 1.5, marks=BETWEEN), (2.5, 3.0), (10.0, 2.0)],
)
def test_a_limited_jerk_gives_the_fastest_profile_without_overshoot(jerk, accel):
    """Up by the jerk to the limit, or as far as half the way allows, and down: v / a + a / j, or 2 sqrt(v / j)."""
    speed = 8.3
    car = moving(0.0, ackermann(speed_m_s=speed, accel_m_s2=accel, jerk_m_s3=jerk))
    full = accel * accel / jerk < speed
    expected_s = speed / accel + accel / jerk if full else 2 * math.sqrt(speed / jerk)
    rows = run(car, expected_s + 1)
    accels = [0.0, *(a for _, a in rows)]
    assert max(abs(b - a) * HZ for a, b in itertools.pairwise(accels)) <= jerk * (1 + 1e-9)
    assert max(accels) <= accel * (1 + 1e-9)
    assert max(v for v, _ in rows) - speed < 1e-5
    assert rows[-1] == (pytest.approx(speed, abs=1e-12), 0.0)
    reached = next(index for index, (v, _) in enumerate(rows, 1) if v > speed - 1e-3)
    assert reached / HZ == pytest.approx(expected_s, abs=0.05 + math.sqrt(2e-3 / jerk))


def test_jerk_holds_for_slowing_down_too():
    car = moving(8.0, ackermann(speed_m_s=3.0, accel_m_s2=2.0, jerk_m_s3=2.0))
    accels = [0.0, *(a for _, a in run(car, 5.0))]
    assert min(accels) == pytest.approx(-2.0, rel=1e-9)
    assert max(abs(b - a) * HZ for a, b in itertools.pairwise(accels)) <= 2.0 * (1 + 1e-9)
    assert car.lon_speed_m_s == pytest.approx(3.0, abs=1e-9)


@each("speed", [1.0, 5.0, 10.0, 15.0])
@each("limit", [0.0, 1.0])
def test_speed_zero_stops_with_all_the_brakes_whatever_the_limits(speed, limit):
    """v^2 / (2 * 8 m/s²); the hand brake below 0.1 m/s and the length of a step change it by 0.6 mm at most."""
    car = moving(speed, ackermann(speed_m_s=0.0, accel_m_s2=limit, jerk_m_s3=limit))
    run(car, speed / P.max_decel_m_s2 + 0.1)
    assert car.lon_speed_m_s == 0.0
    assert car.pose.x_m == pytest.approx(speed**2 / 2 / P.max_decel_m_s2, abs=6e-4)


def test_the_whole_brake_stops_as_resistance_adds_to_it():
    """Closed form of v' = -(a + b v^2): the way is ln(1 + b v^2 / a) / (2 b)."""
    a = P.max_decel_m_s2 + 9.81 * P.rolling_resistance
    b = P.air_density_kg_m3 * P.drag_coefficient * P.drag_area_m2 / 2 / P.mass_kg
    car = moving(20.0, CarCommand(brake=1.0))
    run(car, 3.0)
    assert car.pose.x_m == pytest.approx(math.log1p(b * 400 / a) / 2 / b, abs=1e-3)


def test_coasting_slows_down_by_rolling_resistance_and_drag():
    """Closed form of v' = -(a + b v^2): v = sqrt(a/b) tan(atan(v0 sqrt(b/a)) - sqrt(ab) t)."""
    a = 9.81 * P.rolling_resistance
    b = P.air_density_kg_m3 * P.drag_coefficient * P.drag_area_m2 / 2 / P.mass_kg
    car = moving(20.0, CarCommand())
    run(car, 60.0)
    expected = math.sqrt(a / b) * math.tan(math.atan(20 * math.sqrt(b / a)) - math.sqrt(a * b) * 60)
    assert car.lon_speed_m_s == pytest.approx(expected, rel=1e-9)
