"""Physics of rigid bodies against what mechanics says in closed form; negative tests show that these can fail."""

from __future__ import annotations

import math

import pytest

from measure.physics_oracles import GRAVITY_M_S2, driving, free_fall, self_check
from tests.rigid import BULLET, push, put, turn_joint
from worlds import Box, PhysicsOutputError, Scene, Start, Vehicle, WorldError, bullet
from worlds.scenes.builtin import RAMP_SLOPE_RAD
from worlds.vehicles.model import Axle, BoxShape, Part, SphereShape, box_inertia, sphere_inertia

ONLY_BULLET = pytest.mark.parametrize("physics", [BULLET])


def ball(mass_kg=1.0):
    return Vehicle(
        name="ball",
        parts=(
            Part(
                name="ball",
                mass_kg=mass_kg,
                center_of_mass_m=(0, 0, 0),
                inertia_kg_m2=sphere_inertia(mass_kg, 0.1),
                shapes=(SphereShape(radius_m=0.1, center_m=(0, 0, 0)),),
            ),
        ),
    )


def brick(friction):
    size = (0.4, 0.4, 0.1)
    return Vehicle(
        name="brick",
        parts=(
            Part(
                name="brick",
                mass_kg=2.0,
                center_of_mass_m=(0, 0, 0.05),
                inertia_kg_m2=box_inertia(2.0, size),
                shapes=(BoxShape(size_m=size, center_m=(0, 0, 0.05)),),
                friction=friction,
            ),
        ),
    )


def fall_from_100_m(open_it, step_hz, prepare=lambda world: None):
    world = open_it(Scene(name="fall", start=Start(z_m=100.0)), ball(), step_hz=step_hz)
    prepare(world)
    for _ in range(2 * step_hz):
        world.step()
    return world


def euler_height_m(step_hz):
    steps = 2 * step_hz
    return 100.0 - GRAVITY_M_S2 * steps * (steps + 1) / 2 / step_hz**2


@pytest.mark.parametrize("step_hz", [240, 1000])
def test_free_fall_is_undamped(open_it, step_hz):
    world = fall_from_100_m(open_it, step_hz)
    assert world.pose().position_m[2] == pytest.approx(euler_height_m(step_hz), abs=1e-6)
    assert world.velocity().linear_m_s[2] == pytest.approx(-2 * GRAVITY_M_S2, abs=1e-9)


def test_a_spin_is_undamped(open_it):
    world = fall_from_100_m(open_it, 240, lambda world: push(world, (0, 0, 0), (0, 0, 5.0)))
    assert world.velocity().angular_rad_s == pytest.approx((0, 0, 5.0), abs=1e-9)


@ONLY_BULLET
def test_the_default_damping_would_be_seen(open_it):
    def damp(world):
        world._engine.changeDynamics(
            world._body, -1, linearDamping=0.04, angularDamping=0.04, physicsClientId=world._client
        )

    world = fall_from_100_m(open_it, 240, damp)
    assert world.pose().position_m[2] - euler_height_m(240) > 1.0


@pytest.mark.parametrize("step_hz", [240, 1000])
@pytest.mark.parametrize("friction", [0.2, 0.5, 1.0])
def test_a_sliding_box_stops_where_coulomb_says(open_it, friction, step_hz):
    world = open_it("empty", brick(friction), step_hz=step_hz)
    for _ in range(step_hz // 10):
        world.step()
    start = world.pose().position_m[0]
    push(world, (5.0, 0, 0))
    for _ in range(4 * step_hz):
        world.step()
    slid = world.pose().position_m[0] - start
    assert slid == pytest.approx(25 / (2 * friction * GRAVITY_M_S2), abs=1.1 * 5.0 / step_hz / 2)


@pytest.mark.parametrize(("friction", "holds"), [(0.5, True), (0.2, False)])
def test_a_box_on_an_incline(open_it, friction, holds):
    slope = math.radians(20)
    plank = Box(name="plank", center_m=(0, 0, 0), size_m=(20, 2, 0.2), pitch_rad=-slope)
    scene = Scene(name="incline", boxes=(plank,), floor_friction=0.0)
    world = open_it(scene, brick(friction), step_hz=1000)
    lie_flat_on(world, slope, 0.1)
    settled = None
    for step in range(1700):
        world.step()
        if step == 199:
            settled = world.pose().position_m, world.velocity().linear_m_s
    moved = math.dist(world.pose().position_m, settled[0])
    if holds:
        assert moved < 1e-3
    else:
        acceleration = GRAVITY_M_S2 * (math.sin(slope) - friction * math.cos(slope))
        speed = math.hypot(*settled[1])
        assert moved == pytest.approx(speed * 1.5 + acceleration * 1.5**2 / 2, rel=5e-3)


def lie_flat_on(world, slope, half_thickness):
    """Put the brick 6 m up a plank through the origin, its lower face on the plank's upper one."""
    along, up = (math.cos(slope), 0, math.sin(slope)), (-math.sin(slope), 0, math.cos(slope))
    middle = [6 * a + (half_thickness + 0.05) * u for a, u in zip(along, up, strict=True)]
    put(world, middle, -slope)


@pytest.mark.parametrize("step_hz", [240, 1000])
def test_a_pendulum_keeps_time_and_energy(open_it, step_hz):
    bob = Part(
        name="bob",
        mass_kg=1.0,
        center_of_mass_m=(0, 0, 9.0),
        inertia_kg_m2=sphere_inertia(1.0, 0.01),
        axle=Axle(origin_m=(0, 0, 10.0)),
    )
    pivot = Part(name="pivot", mass_kg=0.0, center_of_mass_m=(0, 0, 10.0), inertia_kg_m2=(1, 1, 1))
    world = open_it("empty", Vehicle(name="pendulum", parts=(pivot, bob)), step_hz=step_hz)
    amplitude = math.radians(5)
    turn_joint(world, "bob", amplitude)
    crossings, before, peaks = [], amplitude, []
    for step in range(1, 10 * step_hz):
        world.step()
        angle = world.joint("bob").angle_rad
        if before < 0 <= angle:
            crossings.append((step - angle / (angle - before)) / step_hz)
        before = angle
        peaks.append(angle)
    inertia = 1.0 + 0.4 * 0.01**2
    small = math.tau * math.sqrt(inertia / GRAVITY_M_S2)
    expected = small * (1 + amplitude**2 / 16)
    assert (crossings[-1] - crossings[0]) / (len(crossings) - 1) == pytest.approx(expected, rel=1e-4)
    assert max(peaks[-3 * step_hz :]) == pytest.approx(amplitude, rel=0.01)


def test_the_ramp_is_as_steep_as_it_says():
    assert math.degrees(RAMP_SLOPE_RAD) == pytest.approx(8.0)


def test_the_self_check_passes(physics):
    findings = self_check(physics)
    assert [finding.name for finding in findings] == ["free fall", "rolling", "driving"]
    assert all(finding.passed for finding in findings), findings


def test_the_self_check_can_fail(monkeypatch, physics):
    monkeypatch.setattr(f"worlds.{physics}_builder.GRAVITY_M_S2", 9.80)
    assert not free_fall(physics).passed


@ONLY_BULLET
def test_the_check_of_torques_can_fail(monkeypatch, physics):
    monkeypatch.setattr("worlds.bullet_builder.Builder._add_inertia", lambda *_: None)
    assert not driving(physics).passed


def test_an_impossible_inertia_is_an_error_not_a_zero(open_it, physics):
    broken = Part(name="flat", mass_kg=1.0, center_of_mass_m=(0, 0, 0), inertia_kg_m2=(1.0, 1.0, 9.0))
    with pytest.raises(WorldError, match="b3Warning" if physics == "bullet" else "refused .*'flat'.*inertia"):
        open_it("empty", Vehicle(name="flat", parts=(broken,)))


@ONLY_BULLET
def test_a_refused_vehicle_leaves_the_next_one_unharmed(open_it):
    broken = Part(name="flat", mass_kg=1.0, center_of_mass_m=(0, 0, 0), inertia_kg_m2=(1.0, 1.0, 9.0))
    open_it("empty", ball()).close()
    spare = len(bullet._idle_clients)
    for _ in range(3):
        with pytest.raises(PhysicsOutputError):
            open_it("empty", Vehicle(name="flat", parts=(broken,)))
    assert len(bullet._idle_clients) == spare
    assert free_fall("bullet").passed
