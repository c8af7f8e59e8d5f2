"""The signals of a world with a Pioneer: names, units, and that they are what they say."""

from __future__ import annotations

import contextlib
import math

import pytest

from hilbench.systems.pioneer.robot import sonar_poses
from hilbench.systems.pioneer.signals import PIONEER_SIGNALS, PioneerSignals
from targets.parts import Direction
from worlds.vehicles.pioneer_2dx import DEFAULTS, Pioneer2dxBody
from worlds.world import open_world


@pytest.fixture
def body():
    with contextlib.ExitStack() as opened:

        def make(scene="empty", physics="plane"):
            world = open_world(scene, "pioneer-2dx", physics=physics)
            opened.callback(world.close)
            return Pioneer2dxBody(world, sonar_poses=sonar_poses("p2dx"))

        yield make


def test_names_directions_and_units():
    taken = {name for name, signal in PIONEER_SIGNALS.items() if signal.direction is Direction.OUT}
    assert taken == {"wheel_left", "wheel_right"}
    assert {PIONEER_SIGNALS[name].unit for name in taken} == {"m/s"}
    assert PIONEER_SIGNALS["wheel_left_angle"].unit == PIONEER_SIGNALS["wheel_right_angle"].unit == "rad"
    rays = {name for name, signal in PIONEER_SIGNALS.items() if signal.by_rays}
    assert rays == {f"{kind}_{number}" for kind in ("ray", "sonar") for number in range(1, 17)}
    assert {PIONEER_SIGNALS[name].unit for name in rays} == {"m"}


def test_a_rim_s_speed_is_what_the_wheel_then_turns_by(body):
    vehicle = body()
    signals = PioneerSignals(vehicle, ["wheel_left_angle", "wheel_right_angle"])
    signals.drive("wheel_left", 0.1)
    signals.drive("wheel_right", -0.2)
    steps = vehicle.world.step_hz
    for _ in range(steps):
        vehicle.world.step()
    values = signals.read()
    assert values["wheel_left_angle"] == pytest.approx(0.1 / DEFAULTS.wheel_radius_m, rel=1e-6)
    assert values["wheel_right_angle"] == pytest.approx(-0.2 / DEFAULTS.wheel_radius_m, rel=1e-6)


def test_only_what_is_wanted_is_read(body):
    assert PioneerSignals(body(), []).read() == {}
    assert [*PioneerSignals(body(), ["wheel_right_angle"]).read()] == ["wheel_right_angle"]


def test_where_nothing_is_there_is_no_end(body):
    values = PioneerSignals(body(), ["ray_1", "sonar_16", "sonar_4"]).read()
    assert values == {"ray_1": math.inf, "sonar_16": math.inf, "sonar_4": math.inf}


@pytest.mark.needs_physics
def test_a_ray_goes_along_the_axis_and_a_cone_finds_the_nearest(body):
    """Discs 4 and 5 look 10 degrees to either side; the wall is 2 m ahead of the middle of the robot."""
    vehicle = body("wall", None)
    signals = PioneerSignals(vehicle, ["ray_4", "ray_5", "sonar_4", "ray_1"])
    values = signals.read()
    x_m, _, turn_rad = sonar_poses("p2dx")[3]
    assert values["ray_4"] == pytest.approx((2.0 - x_m) / math.cos(turn_rad), abs=1e-3)
    assert values["ray_5"] == pytest.approx(values["ray_4"], abs=1e-6)
    assert values["sonar_4"] == pytest.approx(2.0 - x_m, rel=1e-3)
    assert values["ray_1"] == math.inf


@pytest.mark.needs_physics
def test_the_rear_ring_is_there_too(body):
    vehicle = body("wall", None)
    vehicle.world.place(0.0, 0.0, math.pi)
    values = PioneerSignals(vehicle, ["ray_4", "ray_12", "ray_13"]).read()
    assert values["ray_4"] == math.inf
    assert values["ray_12"] == pytest.approx(values["ray_13"], abs=1e-3)
    assert values["ray_12"] < 2.0
