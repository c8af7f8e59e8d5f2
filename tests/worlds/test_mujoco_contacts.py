"""Which of MuJoCo's constraints belong to a contact."""

from __future__ import annotations

import pytest

from tests.rigid import MUJOCO
from worlds.vehicles.pioneer_2dx import LEFT, RIGHT

pytestmark = pytest.mark.parametrize("physics", [MUJOCO])


def test_a_contact_that_just_does_not_touch_has_none(open_it):
    """A caster whose contact counts from 1 mm in the floor on, and is listed before, carries nothing."""
    world = open_it("empty", "pioneer-2dx")
    model = world._model
    for number, geoms in enumerate(zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True)):
        if world._pairs[geoms][0] == "caster":
            model.pair_margin[number], model.pair_gap[number] = -0.001, 0.01
    for speed in (1.0, 2.0, 3.0):
        world.command(LEFT, speed, 1.0)
        world.command(RIGHT, speed, 1.0)
        world.step()
        assert sorted(contact.part for contact in world.contacts()) == ["caster", LEFT, RIGHT]
        assert world.contacts("caster")[0].normal_force_n == 0.0
        assert all(contact.normal_force_n > 0.0 for wheel in (LEFT, RIGHT) for contact in world.contacts(wheel))
    assert world.joint(LEFT).speed_rad_s > 0.5
