"""The path-following driver on the car's own dynamics around the test track, without a board between them."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from targets.robots.driving_stack import DriverSettings, Path, PathDriver, Pose
from worlds.car_commands import CarCommand, CommandMode
from worlds.car_dynamics import CarDynamics
from worlds.car_parameters import DEFAULTS
from worlds.scenes.track import LANE_WIDTH_M, track

STEP_S = 1 / 240
REPORT_S = 1 / 20
COMMAND_S = 1 / 30


@pytest.fixture
def lap():
    """Drive once around; a report every 50 ms, a command every 33 ms, which arrives after a while, times a factor."""

    def lap(settings=None, *, factor=1.0, delay_s=0.03):
        lane = track(0).lane
        path = Path(lane.center_m, closed=lane.closed)
        driver, car = PathDriver(path, settings), CarDynamics()
        under_way, offsets_m, lateral_m_s2 = [], [], []
        now_s, report_s, command_s = 0.0, 0.0, 0.0
        while driver.travelled_m < path.length_m and now_s < 200:
            if now_s >= report_s:
                pose = Pose(x_m=car.pose.x_m, y_m=car.pose.y_m, yaw_rad=car.pose.yaw_rad)
                report = (pose, car.lon_speed_m_s)
                report_s += REPORT_S
            if now_s >= command_s:
                under_way.append((now_s + delay_s, driver.command(*report)))
                command_s += COMMAND_S
                place = path.place(car.pose.x_m, car.pose.y_m, near_m=driver.place.s_m, within_m=20.0)
                offsets_m.append(abs(place.offset_m))
                lateral_m_s2.append(abs(car.lon_speed_m_s * car.yaw_rate_rad_s))
            while under_way and under_way[0][0] <= now_s:
                car.layer.command = obeyed(under_way.pop(0)[1], factor)
            car.advance(STEP_S)
            now_s += STEP_S
        return SimpleNamespace(s=now_s, offset_m=max(offsets_m), lateral_m_s2=max(lateral_m_s2), length_m=path.length_m)

    return lap


def obeyed(command, factor):
    return CarCommand(
        mode=CommandMode.ACKERMANN,
        steering_rad=factor * command.steering_tire_angle,
        steering_rate_rad_s=factor * command.steering_tire_rotation_rate,
        speed_m_s=command.speed,
        accel_m_s2=command.acceleration,
        jerk_m_s3=command.jerk,
    )


def test_the_wheelbase_that_the_driver_knows_is_the_cars():
    assert DriverSettings().wheelbase_m == DEFAULTS.wheelbase_m
    assert DriverSettings().steering_limit_rad <= DEFAULTS.max_steering_rad
    assert DriverSettings().steering_rate_rad_s <= DEFAULTS.max_steering_rate_rad_s


LESS = pytest.mark.exhaustive("the gate has the longest delay, at which a driver strays furthest")


@pytest.mark.parametrize("delay_s", [pytest.param(0.0, marks=LESS), pytest.param(0.03, marks=LESS), 0.1])
def test_a_lap_keeps_well_within_the_lane(lap, delay_s):
    driven = lap(delay_s=delay_s)
    assert driven.offset_m < 0.2 < (LANE_WIDTH_M - DEFAULTS.width_m) / 2
    assert driven.lateral_m_s2 < 1.5 * DriverSettings().lateral_m_s2
    assert driven.length_m / 10 < driven.s < driven.length_m / 6


@pytest.mark.exhaustive("a second lap; the gate has the one with the longest delay")
def test_steering_that_is_a_fifth_too_large_is_made_up_for(lap):
    assert lap(factor=1.2).offset_m < 0.3
