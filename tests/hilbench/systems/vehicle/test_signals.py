"""The signals of a world with a car: names, units, and that they are what they say."""

from __future__ import annotations

import math

import pytest

from hilbench.errors import UsageError
from hilbench.systems.vehicle.signals import CAR_SIGNALS, CarSignals
from targets.parts import Direction
from worlds.errors import WorldError
from worlds.vehicles.car import CarBody
from worlds.world import open_world

GIVEN = [name for name, signal in CAR_SIGNALS.items() if signal.direction is Direction.IN]


@pytest.fixture
def car():
    opened = []

    def make(scene="empty", physics="plane"):
        opened.append(open_world(scene, "car", physics))
        return CarBody(opened[-1])

    yield make
    for world in opened:
        world.close()


def drive(body, steps=240, **values):
    signals = CarSignals(body, GIVEN)
    for name, value in values.items():
        signals.drive(name, value)
    for _ in range(steps):
        body.world.step()
    return signals.read()


def test_names_directions_and_units():
    taken = {name: signal.unit for name, signal in CAR_SIGNALS.items() if signal.direction is Direction.OUT}
    assert taken == {
        "command_mode": "1",
        "steering_command": "rad",
        "steering_rate_limit": "rad/s",
        "speed_command": "m/s",
        "accel_limit": "m/s2",
        "jerk_limit": "m/s3",
        "throttle": "1",
        "brake": "1",
        "steer": "1",
        "hand_brake": "1",
    }
    assert {name for name, signal in CAR_SIGNALS.items() if signal.by_rays} == {"ray_left", "ray_middle", "ray_right"}


def test_every_given_signal_can_be_read(car):
    assert list(drive(car(), 10)) == GIVEN


def test_before_any_command_the_pedals_count_and_are_free(car):
    body = car()
    assert drive(body, speed_command=5.0, steering_command=0.2)["x"] == 0.0
    assert drive(body, throttle=0.2)["x"] > 0.1


def test_an_ackermann_command_is_obeyed_within_its_limits(car):
    body = car()
    values = drive(body, command_mode=1, speed_command=5.0, accel_limit=2.0, steering_command=0.1)
    assert (values["lon_speed"], values["lon_accel"]) == pytest.approx((2.0, 2.0))
    assert values["steering"] == pytest.approx(0.1)
    assert min(values["x"], values["y"], values["yaw"], values["yaw_rate"]) > 0
    values = drive(body, accel_limit=0.0, jerk_limit=1.0, steering_rate_limit=0.01, steering_command=0.2)
    assert values["steering"] == pytest.approx(0.11)
    assert drive(body, 2400, jerk_limit=0.0)["lon_speed"] == pytest.approx(5.0)
    assert drive(body, speed_command=0.0)["lon_speed"] == 0.0


def test_pedals_are_obeyed(car):
    body = car()
    assert drive(body, throttle=1.0)["lon_accel"] == pytest.approx(3.0, rel=0.05)
    slower = drive(body, 1, throttle=0.0, brake=0.5)["lon_accel"]
    assert slower == pytest.approx(-4.0, rel=0.05)
    assert drive(body, 1, brake=0.0, hand_brake=1)["lon_accel"] == pytest.approx(-4.3, rel=0.05)
    assert drive(body, 240, hand_brake=0, steer=-0.5)["steering"] == pytest.approx(-0.5146, abs=1e-4)


def test_speeds_and_place_are_those_of_the_world(car):
    body = car()
    values = drive(body, 960, command_mode=1, speed_command=8.0, steering_command=0.1)
    pose, velocity = body.world.pose(), body.world.velocity()
    assert (values["x"], values["y"], values["yaw"]) == (*pose.position_m[:2], pose.yaw_rad)
    speed = math.hypot(values["lon_speed"], values["lat_speed"])
    assert math.hypot(*velocity.linear_m_s[:2]) == pytest.approx(speed)
    assert values["yaw_rate"] == velocity.angular_rad_s[2]


def test_what_is_not_finite_is_refused(car):
    with pytest.raises(WorldError, match="not finite"):
        drive(car(), throttle=math.nan)


@pytest.mark.needs_physics
def test_rays_and_contact_tell_of_obstacles(car):
    body = car("test-track", None)
    ahead = 120.0 - body.parameters.front_bumper_m
    values = drive(body, 1)
    assert [values[name] for name in ("ray_left", "ray_middle", "ray_right")] == [math.inf] * 3
    body.world.place(100.0, 0.0, 0.0)
    values = drive(body, 1)
    assert [values[name] for name in ("ray_left", "ray_middle", "ray_right")] == pytest.approx(
        [ahead - 100] * 3, abs=1e-6
    )
    assert values["contact"] == 0.0
    values = drive(body, 1200, command_mode=1, speed_command=5.0)
    assert (values["contact"], values["ray_middle"]) == (1.0, pytest.approx(0.0, abs=0.01))
    assert values["lon_speed"] == pytest.approx(0.0, abs=0.01)
    body.world.place(0.0, 5.0, 0.0)
    assert drive(body, 1)["ray_right"] == pytest.approx(math.inf)
    body.world.place(100.0, 6.5, 0.0)
    values = drive(body, 1)
    assert (values["ray_left"], values["ray_middle"]) == (math.inf, math.inf)
    assert values["ray_right"] == pytest.approx(ahead - 100, abs=1e-6)


BENCH = """version = 1
[targets.brain]
board = "bluepill"
firmware = "a.elf"
[world]
vehicle = "car"
physics = "plane"
[parts.one]
"""


def test_a_part_may_drive_a_car_on_the_plane(read):
    part = 'kind = "gamepad"\nsignals = { left = "world.speed_command" }\n'
    assert read(BENCH + part).parts["one"].signals == {"left": "speed_command"}


def test_rays_need_obstacles(read):
    part = 'kind = "distance-switch"\npins = { out = "brain.PA0" }\nsignals = { range = "world.ray_middle" }\n'
    with pytest.raises(UsageError, match="has no rays"):
        read(BENCH + part)
    assert read(BENCH.replace('physics = "plane"\n', "") + part).parts["one"].signals == {"range": "ray_middle"}
