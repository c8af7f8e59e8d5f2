"""The signals of a world with a rover: names, units, and that they are what they say."""

from __future__ import annotations

import math

import pytest

from hilbench.plugins.discovery import PLUGINS
from hilbench.systems.rover.signals import ROVER_SIGNALS, RoverSignals
from targets.parts import Direction
from worlds import vehicle_names
from worlds.vehicles.rover_4wd import WHEELS, Rover4wdBody
from worlds.world import open_world


@pytest.fixture
def rover():
    opened = []

    def make(scene="carpet"):
        world = open_world(scene, "rover-4wd")
        opened.append(world)
        return Rover4wdBody(world)

    yield make
    for world in opened:
        world.close()


def run(body, signals, steps):
    for _ in range(steps):
        body.world.step()
        values = signals.read()
    return values


def test_every_vehicle_has_signals():
    names = PLUGINS.systems.vehicle_names()
    assert {*names} == {*vehicle_names()}
    for signals in (PLUGINS.systems.vehicle(name).signals for name in names):
        assert all(name == signal.name and signal.unit and signal.text for name, signal in signals.items())


def test_names_directions_and_units():
    taken = {name for name, signal in ROVER_SIGNALS.items() if signal.direction is Direction.OUT}
    assert taken == {f"{wheel}_{what}" for wheel in WHEELS for what in ("torque", "friction")}
    assert {ROVER_SIGNALS[name].unit for name in taken} == {"N·m"}
    units = {"x": "m", "vy": "m/s", "az": "m/s2", "wx": "rad/s", "yaw": "rad", "wheel_lb_speed": "rad/s"}
    assert {name: ROVER_SIGNALS[name].unit for name in units} == units
    assert not any(signal.by_rays for signal in ROVER_SIGNALS.values())


@pytest.mark.needs_physics
def test_every_given_signal_can_be_read(rover):
    given = [name for name, signal in ROVER_SIGNALS.items() if signal.direction is Direction.IN]
    body = rover()
    values = run(body, RoverSignals(body, given), 48)
    assert list(values) == given
    at_rest = {name: value for name, value in values.items() if name not in {"az"} and "contact" not in name}
    assert at_rest == pytest.approx(dict.fromkeys(at_rest, 0.0), abs=1e-4)
    assert values["az"] == pytest.approx(9.81, abs=1e-3)
    assert [values[f"{wheel}_contact"] for wheel in WHEELS] == [1.0] * 4
    assert values["body_contact"] == 0.0


@pytest.mark.needs_physics
def test_each_signal_is_the_one_of_its_name(rover):
    """Turning to the left while it rolls: everything that has a direction shows it."""
    body = rover("hard-floor")
    names = ["x", "y", "vx", "vy", "yaw", "wz", "ax", "ay", "wheel_lf_speed", "wheel_rf_speed", "wheel_rb_angle"]
    signals = RoverSignals(body, names)
    for wheel in WHEELS:
        signals.drive(f"{wheel}_friction", 0.0)
        signals.drive(f"{wheel}_torque", 0.01 if wheel.startswith("wheel_l") else 0.05)
    values = run(body, signals, 60)
    pose, velocity = body.world.pose(), body.world.velocity()
    assert (values["x"], values["y"]) == pose.position_m[:2]
    assert (values["vx"], values["vy"]) == velocity.linear_m_s[:2]
    assert values["yaw"] == pose.yaw_rad > 0
    assert values["wz"] == pytest.approx(velocity.angular_rad_s[2], rel=1e-3)  # about an axis of the body, which leans
    assert values["wz"] > 0.1
    assert values["ax"] > 0.1
    assert values["wheel_rf_speed"] > values["wheel_lf_speed"] > 0
    assert values["wheel_rb_angle"] == body.wheel("wheel_rb").angle_rad


@pytest.mark.needs_physics
def test_a_torque_turns_a_wheel_in_the_air_against_its_friction(rover):
    body = rover("stand")
    signals = RoverSignals(body, ["wheel_rb_speed", "wheel_rb_contact", "body_contact", "z"])
    signals.drive("wheel_rb_torque", 0.010)
    signals.drive("wheel_rb_friction", 0.004)
    values = run(body, signals, 120)
    p = body.parameters
    inertia = p.reflected_inertia_kg_m2 + p.wheel_mass_kg * p.wheel_radius_m**2 / 2
    assert values["wheel_rb_speed"] == pytest.approx(0.006 / inertia * 0.5, rel=1e-3)
    assert (values["wheel_rb_contact"], values["body_contact"]) == (0.0, 1.0)
    assert values["z"] == pytest.approx(0.03, abs=1e-3)


@pytest.mark.needs_physics
def test_without_a_friction_the_wheel_has_the_vehicle_s(rover):
    body = rover("stand")
    signals = RoverSignals(body, ["wheel_lf_speed"])
    signals.drive("wheel_lf_torque", 0.0119)
    assert run(body, signals, 60)["wheel_lf_speed"] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.needs_physics
def test_attitude_has_its_own_signs(rover):
    body = rover("ramp")
    signals = RoverSignals(body, ["pitch", "roll", "x", "ax"])
    for wheel in WHEELS:
        signals.drive(f"{wheel}_friction", 0.0)
        signals.drive(f"{wheel}_torque", 0.02)
    while body.world.pose().position_m[0] < 1.9:
        values = run(body, signals, 1)
    assert values["pitch"] == pytest.approx(-math.radians(8), abs=0.01)
    assert values["roll"] == pytest.approx(0.0, abs=1e-3)
    assert values["ax"] > 9.81 * math.sin(math.radians(8))
