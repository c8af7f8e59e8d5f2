"""What a physics of rigid bodies refuses, in words of its own and alike on both."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from worlds import Box, Scene, WorldError, find_vehicle
from worlds.vehicles.pioneer_2dx import LEFT


@pytest.mark.parametrize("where", [(math.nan, 0, 0), (0, math.inf, 0), (0, 0, math.nan)])
def test_a_place_that_is_no_number(open_it, physics, where):
    with pytest.raises(WorldError, match="cannot place the 'pioneer-2dx'"):
        open_it("empty", "pioneer-2dx", physics).place(*where)


def test_rays_that_do_not_pair(open_it, physics):
    with pytest.raises(WorldError, match="2 begin and 1 end"):
        open_it("empty", "pioneer-2dx", physics).cast([(0, 0, 1), (0, 0, 2)], [(1, 0, 1)])


def test_a_wheel_without_mass(open_it, physics):
    pioneer = find_vehicle("pioneer-2dx")
    light = tuple(replace(part, mass_kg=0.0) if part.name == LEFT else part for part in pioneer.parts)
    with pytest.raises(WorldError, match="'wheel_left' turns and has no mass"):
        open_it("empty", replace(pioneer, parts=light), physics)


@pytest.mark.needs_mujoco
def test_boxes_of_one_name_are_the_scene_s_fault(open_it):
    box = Box(name="a", center_m=(3, 0, 0.1), size_m=(0.2, 0.2, 0.2))
    with pytest.raises(WorldError, match="refused 'pioneer-2dx' in scene 'twins'"):
        open_it(Scene(name="twins", boxes=(box, box)), "pioneer-2dx", "mujoco")


def test_a_torque_reads_as_it_was_in_the_last_step(open_it, physics):
    world = open_it("empty", "pioneer-2dx", physics)
    for _ in range(20):
        world.drive(LEFT, 0.1, 0.0)
        world.step()
    before = world.joint(LEFT).torque_nm
    world.drive(LEFT, -0.5, 0.0)
    world._forget()
    assert world.joint(LEFT).torque_nm == pytest.approx(before, abs=1e-9)
