"""Joints driven by a torque, against the rigid wheel of the textbook: dw/dt = (torque - friction) / inertia."""

from __future__ import annotations

import math

import pytest

from worlds import Vehicle, WorldError
from worlds.vehicles.model import Axle, Part, wheel_inertia

REFLECTED_KG_M2 = 3.2e-4
CREEPS_RAD_S = {"bullet": 1e-12, "mujoco": 1e-7}
"""How fast a wheel turns that dry friction holds: a constraint of MuJoCo is never quite rigid."""
OWN_KG_M2 = wheel_inertia(0.034, 0.0325, 0.026)[1]


def flywheel(reflected_kg_m2=REFLECTED_KG_M2, friction_nm=0.0):
    """A wheel on a fixed axle in the air."""
    hub = Part(name="hub", mass_kg=0.0, center_of_mass_m=(0, 0, 1), inertia_kg_m2=(1, 1, 1))
    wheel = Part(
        name="wheel",
        mass_kg=0.034,
        center_of_mass_m=(0, 0, 1),
        inertia_kg_m2=wheel_inertia(0.034, 0.0325, 0.026),
        axle=Axle(origin_m=(0, 0, 1), friction_nm=friction_nm, reflected_inertia_kg_m2=reflected_kg_m2),
    )
    return Vehicle(name="flywheel", parts=(hub, wheel))


def spin(world, seconds, torque_nm, friction_nm=None):
    for _ in range(round(seconds * world.step_hz)):
        world.drive("wheel", torque_nm, friction_nm)
        world.step()
    return world.joint("wheel").speed_rad_s


@pytest.mark.parametrize("reflected", [0.0, REFLECTED_KG_M2])
@pytest.mark.parametrize("step_hz", [240, 1000])
def test_a_torque_turns_what_it_has_to_turn(open_it, step_hz, reflected):
    world = open_it("empty", flywheel(reflected), step_hz=step_hz)
    assert spin(world, 0.5, 1e-3) == pytest.approx(1e-3 / (OWN_KG_M2 + reflected) * 0.5, rel=1e-6)


def test_dry_friction_takes_its_share(open_it):
    world = open_it("empty", flywheel())
    expected = (0.010 - 0.004) / (OWN_KG_M2 + REFLECTED_KG_M2) * 0.5
    assert spin(world, 0.5, 0.010, 0.004) == pytest.approx(expected, rel=1e-6)
    assert world.joint("wheel").torque_nm == pytest.approx(0.006, rel=1e-6)


@pytest.mark.parametrize("torque_nm", [0.0039, -0.0039])
def test_below_friction_nothing_moves(open_it, physics, torque_nm):
    world = open_it("empty", flywheel())
    creeps_rad_s = CREEPS_RAD_S[physics]
    assert spin(world, 1.0, torque_nm, 0.004) == pytest.approx(0.0, abs=creeps_rad_s)
    assert world.joint("wheel").angle_rad == pytest.approx(0.0, abs=creeps_rad_s)
    assert world.joint("wheel").torque_nm == pytest.approx(0.0, abs=1e-9)


def test_friction_stops_a_wheel_and_does_not_turn_it_back(open_it):
    world = open_it("empty", flywheel())
    spin(world, 0.5, 0.010, 0.0)
    assert spin(world, 1.0, 0.0, 0.010) == pytest.approx(0.0, abs=1e-9)


def test_without_a_friction_the_joint_has_its_own(open_it, physics):
    world = open_it("empty", flywheel(friction_nm=0.004))
    assert spin(world, 0.5, 0.003) == pytest.approx(0.0, abs=CREEPS_RAD_S[physics])


def test_a_torque_stays_until_something_else_is_said(open_it, physics):
    world = open_it("empty", flywheel())
    world.drive("wheel", 1e-3)
    for _ in range(24):
        world.step()
    speed = 24 / 240 * 1e-3 / (OWN_KG_M2 + REFLECTED_KG_M2)
    assert world.joint("wheel").speed_rad_s == pytest.approx(speed, rel=1e-6)
    world.release("wheel")
    world.step()
    assert world.joint("wheel").speed_rad_s == pytest.approx(speed, rel=1e-6)
    assert world.joint("wheel").torque_nm == 0.0
    world.command("wheel", 2.0, 1.0)
    world.step()
    assert world.joint("wheel").speed_rad_s == pytest.approx(2.0, rel=1e-6 if physics == "bullet" else 2e-6)


def test_a_vehicle_that_is_put_down_is_released(open_it):
    world = open_it("empty", flywheel())
    world.drive("wheel", 1e-3)
    world.step()
    world.place(0.0, 0.0, 0.0)
    world.step()
    assert world.joint("wheel").speed_rad_s == 0.0


def test_energy_comes_from_the_torque_alone(open_it):
    world = open_it("empty", flywheel())
    work_j, before = 0.0, 0.0
    for step in range(240):
        torque = 0.01 * math.sin(step / 20)
        world.drive("wheel", torque, 0.0)
        world.step()
        speed = world.joint("wheel").speed_rad_s
        work_j += torque * (before + speed) / 2 / world.step_hz
        before = speed
    energy_j = (OWN_KG_M2 + REFLECTED_KG_M2) * world.joint("wheel").speed_rad_s ** 2 / 2
    assert energy_j == pytest.approx(work_j, rel=1e-6)


def test_a_motor_law_comes_to_its_idle_speed(open_it):
    """As a motor's does: torque = stall (1 - w / idle); the time constant is inertia * idle / stall."""
    world = open_it("empty", flywheel(), step_hz=1000)
    stall_nm, idle_rad_s = 0.08, 20.9
    constant_s = (OWN_KG_M2 + REFLECTED_KG_M2) * idle_rad_s / stall_nm
    for _ in range(round(constant_s * 1000)):
        world.drive("wheel", stall_nm * (1 - world.joint("wheel").speed_rad_s / idle_rad_s))
        world.step()
    assert world.joint("wheel").speed_rad_s == pytest.approx(idle_rad_s * (1 - math.exp(-1)), rel=0.01)
    for _ in range(1000):
        world.drive("wheel", stall_nm * (1 - world.joint("wheel").speed_rad_s / idle_rad_s))
        world.step()
    assert world.joint("wheel").speed_rad_s == pytest.approx(idle_rad_s, rel=1e-4)


@pytest.mark.parametrize(("torque", "friction"), [(math.nan, 0.0), (math.inf, 0.0), (0.1, -1.0), (0.1, math.nan)])
def test_refuses_torques_that_are_no_numbers(open_it, torque, friction):
    world = open_it("empty", flywheel())
    with pytest.raises(WorldError, match="cannot drive"):
        world.drive("wheel", torque, friction)
