"""What every world must do, whatever computes it."""

from __future__ import annotations

import math

import pytest

from tests.rigid import RIGID
from worlds import CapabilityError, Scene, Start, UnknownNameError, WorldError, open_world
from worlds.vehicles.pioneer_2dx import LEFT, RIGHT, Pioneer2dxBody

pytestmark = pytest.mark.parametrize("physics", [*RIGID, "plane"])


@pytest.fixture
def world(open_it, physics):
    return open_it("empty", "pioneer-2dx", physics)


def roll(world, left, right, seconds):
    for _ in range(round(seconds * world.step_hz)):
        world.command(LEFT, left, 1.0)
        world.command(RIGHT, right, 1.0)
        world.step()


def test_says_what_it_is(world, physics):
    assert (world.name, world.step_hz, world.step_index) == (physics, 240, 0)
    assert world.scene.name == "empty"
    assert world.vehicle.name == "pioneer-2dx"
    assert world.capabilities <= {"rays", "contacts", "gravity", "torque"}


def test_starts_at_the_scene_start_at_rest(open_it, physics):
    start = Start(x_m=1.0, y_m=-2.0, yaw_rad=0.5)
    world = open_it(Scene(name="elsewhere", start=start), "pioneer-2dx", physics)
    assert world.pose().position_m == pytest.approx((1.0, -2.0, 0.0), abs=1e-12)
    assert world.pose().yaw_rad == pytest.approx(0.5)
    assert world.velocity().linear_m_s == pytest.approx((0, 0, 0), abs=1e-12)


def test_stands_still_when_nothing_is_commanded(world):
    for _ in range(240):
        world.step()
    assert world.pose().position_m == pytest.approx((0, 0, 0), abs=1e-4)
    assert world.joint(LEFT).angle_rad == pytest.approx(0.0, abs=1e-3)


def test_counts_steps(world):
    for _ in range(7):
        world.step()
    assert world.step_index == 7


def test_positive_wheel_speeds_drive_forward(world):
    roll(world, 4.0, 4.0, 0.5)
    x, y, _ = world.pose().position_m
    assert x > 0.1
    assert abs(y) < 0.01
    assert world.velocity().linear_m_s[0] == pytest.approx(0.33, rel=0.01)
    assert world.joint(LEFT).speed_rad_s == pytest.approx(4.0, rel=0.01)


def test_a_faster_right_wheel_turns_left(world):
    roll(world, -2.0, 2.0, 0.5)
    assert world.pose().yaw_rad > 0.3
    assert world.velocity().angular_rad_s[2] > 0


def test_wheel_angles_are_never_wrapped(world):
    roll(world, 12.0, -12.0, 3.0)
    assert world.joint(LEFT).angle_rad > 30
    assert world.joint(RIGHT).angle_rad < -30
    assert -math.pi <= world.pose().yaw_rad <= math.pi


def test_a_released_robot_comes_to_rest(world):
    roll(world, 4.0, 4.0, 0.5)
    world.release(LEFT)
    world.release(RIGHT)
    for _ in range(480):
        world.step()
    assert math.hypot(*world.velocity().linear_m_s) < 1e-3


def test_place_puts_it_at_rest_and_keeps_wheel_angles(world):
    roll(world, 4.0, 4.0, 0.5)
    angle = world.joint(LEFT).angle_rad
    world.place(3.0, 4.0, -1.0)
    assert world.pose().position_m == pytest.approx((3.0, 4.0, 0.0), abs=1e-9)
    assert world.pose().yaw_rad == pytest.approx(-1.0)
    assert world.joint(LEFT).angle_rad == angle
    for _ in range(10):
        world.step()
    assert world.pose().position_m == pytest.approx((3.0, 4.0, 0.0), abs=1e-3)


def test_torque_goes_with_the_capability(world):
    if "torque" in world.capabilities:
        world.drive(LEFT, 0.1)
    else:
        with pytest.raises(CapabilityError, match="torque"):
            world.drive(LEFT, 0.1)


def test_refuses_joints_it_does_not_have(world):
    with pytest.raises(UnknownNameError, match="'wheel_left'"):
        world.drive("wheel_lfet", 0.1)
    with pytest.raises(UnknownNameError, match="'wheel_left'"):
        world.joint("wheel_lfet")
    with pytest.raises(UnknownNameError):
        world.command("steering", 1.0, 1.0)
    with pytest.raises(UnknownNameError):
        world.release("steering")


@pytest.mark.parametrize(("speed", "torque"), [(math.nan, 1.0), (math.inf, 1.0), (1.0, math.nan), (1.0, -0.1)])
def test_refuses_commands_that_are_no_numbers(world, speed, torque):
    with pytest.raises(WorldError, match="cannot command"):
        world.command(LEFT, speed, torque)


def test_rays_and_contacts_go_with_the_capabilities(world):
    rays = [(0.0, 0.0, 1.0)], [(5.0, 0.0, 1.0)]
    if "rays" in world.capabilities:
        assert list(world.cast(*rays)) == [1.0]
        assert list(world.cast([], [])) == []
    else:
        with pytest.raises(CapabilityError):
            world.cast(*rays)
    if "contacts" in world.capabilities:
        assert world.contacts() == ()
        with pytest.raises(UnknownNameError, match="'nothing'"):
            world.contacts("nothing")
    else:
        with pytest.raises(CapabilityError):
            world.contacts()


def test_a_robot_lives_in_it(world, discs):
    body = Pioneer2dxBody(world, sonar_poses=discs)
    body.command_wheels(1.0, 1.0)
    world.step()
    assert body.bumpers() == (0, 0)
    assert body.sonar_range_m(3) is None
    assert all(0 <= load <= 1 for load in body.motor_loads())


def test_a_closed_world_answers_nothing(physics):
    world = open_world("empty", "pioneer-2dx", physics)
    world.close()
    world.close()
    calls = [
        world.step,
        world.pose,
        world.velocity,
        world.contacts,
        lambda: world.joint(LEFT),
        lambda: world.command(LEFT, 1.0, 1.0),
        lambda: world.release(LEFT),
        lambda: world.drive(LEFT, 0.1),
        lambda: world.place(0, 0, 0),
        lambda: world.cast([(0, 0, 1)], [(1, 0, 1)]),
    ]
    for call in calls:
        with pytest.raises(WorldError, match="closed"):
            call()


@pytest.mark.parametrize("step_hz", [0, -1, 2.5, True, "240"])
def test_refuses_a_bad_step_rate(physics, step_hz):
    with pytest.raises(WorldError, match="step_hz"):
        open_world("empty", "pioneer-2dx", physics, step_hz=step_hz)


def test_names_the_nearest_scene_and_vehicle(physics):
    with pytest.raises(UnknownNameError, match="did you mean 'corridor'"):
        open_world("coridor", "pioneer-2dx", physics)
    with pytest.raises(UnknownNameError, match="did you mean 'pioneer-2dx'"):
        open_world("empty", "pioneer2dx", physics)
    with pytest.raises(UnknownNameError, match="unknown physics"):
        open_world("empty", "pioneer-2dx", physics + "s")
