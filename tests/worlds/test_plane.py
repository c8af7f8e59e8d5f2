from __future__ import annotations

import math

import pytest

from worlds import Vehicle, WorldError, open_world


@pytest.mark.parametrize("physics", ["plane"])
def test_an_arc_is_exact_at_any_step_rate(pioneer):
    for step_hz in (7, 240):
        body = pioneer(step_hz=step_hz)
        p = body.parameters
        left, right = 0.2 / p.wheel_radius_m, 0.3 / p.wheel_radius_m
        for _ in range(5 * step_hz):
            body.command_wheels(left, right)
            body.world.step()
        turn = 0.1 / p.track_m * 5
        radius = 0.25 * 5 / turn
        assert body.world.pose().yaw_rad == pytest.approx(turn, rel=1e-12)
        assert body.world.pose().position_m[:2] == pytest.approx(
            (radius * math.sin(turn), radius * (1 - math.cos(turn))), rel=1e-12
        )


def test_refuses_scenes_with_obstacles():
    with pytest.raises(WorldError, match='use scene "empty"'):
        open_world("wall", "pioneer-2dx", "plane")


def test_refuses_vehicles_without_two_wheels():
    with pytest.raises(WorldError, match="two wheels"):
        open_world("empty", Vehicle(name="sledge", parts=()), "plane")


@pytest.mark.parametrize("physics", ["plane"])
def test_no_torque_is_a_released_wheel(pioneer):
    world = pioneer().world
    world.command("wheel_left", 3.0, 0.0)
    world.step()
    assert world.joint("wheel_left").speed_rad_s == 0.0


@pytest.mark.parametrize(
    ("left", "right", "distance_m"), [(1, 1, 1.5), (-1, 1, 0.28), (2 / 3, 1, 1.2), (1, 0.5, 0.8), (-1, -1, 1.0)]
)
def test_rigid_bodies_agree_with_it_where_nothing_slips(pioneer, physics, drive, left, right, distance_m):
    ends = [drive(pioneer(physics=name), left=left, right=right, distance_m=distance_m) for name in ("plane", physics)]
    plane, rigid = ends
    assert rigid.position_m[:2] == pytest.approx(plane.position_m[:2], abs=2e-3)
    assert rigid.yaw_rad == pytest.approx(plane.yaw_rad, abs=math.radians(0.2))
