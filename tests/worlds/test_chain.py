"""A part that hangs on another part: it goes where that one goes."""

from __future__ import annotations

import math

import pytest

from tests.each import each
from worlds import Vehicle, WorldError
from worlds.scenes import Box, Scene
from worlds.vehicles.model import Axle, BoxShape, Part, box_inertia
from worlds.vehicles.urdf import to_urdf

SIZE_M = (0.2, 0.02, 0.02)
POST = Box(name="post", center_m=(0.0, 0.35, 1.0), size_m=(0.1, 0.1, 0.1))
"""On the left of the crane; its near face is 0.3 m away."""


def crane(on):
    """A mast that turns, and an arm ahead of it that is lifted by an axle of its own."""
    base = Part(name="base", mass_kg=0.0, center_of_mass_m=(0, 0, 1), inertia_kg_m2=(1, 1, 1))
    mast = Part(
        name="mast",
        mass_kg=0.2,
        center_of_mass_m=(0, 0, 1),
        inertia_kg_m2=box_inertia(0.2, (0.05, 0.05, 0.05)),
        axle=Axle(origin_m=(0, 0, 1), axis=(0, 0, 1)),
    )
    middle = (0.25, 0.0, 1.0)
    arm = Part(
        name="arm",
        mass_kg=0.1,
        center_of_mass_m=middle,
        inertia_kg_m2=box_inertia(0.1, SIZE_M),
        shapes=(BoxShape(size_m=SIZE_M, center_m=middle),),
        axle=Axle(origin_m=(0.15, 0.0, 1.0)),
        on=on,
    )
    return Vehicle(name="crane", parts=(base, mast, arm))


@pytest.mark.parametrize(("on", "hits"), [("mast", True), ("", False)], ids=["on the mast", "on the base"])
def test_an_arm_turns_with_what_it_hangs_on(open_it, on, hits):
    world = open_it(Scene(name="post", boxes=(POST,)), crane(on), step_hz=240)
    world.command("arm", 0.0, 5.0)
    world.command("mast", 1.0, 0.5)
    for _ in range(2 * 240):
        world.step()
    touched = {(contact.part, contact.other) for contact in world.contacts()}
    assert touched == ({("arm", "post")} if hits else set())
    # The arm's side meets the near corner of the post when its middle line is half its breadth away from it.
    meets_rad = math.atan2(0.3, 0.05) - math.asin(0.01 / math.hypot(0.05, 0.3))
    assert world.joint("mast").angle_rad == pytest.approx(meets_rad if hits else 2.0, abs=0.01)


def test_an_arm_that_is_lifted_passes_over(open_it):
    world = open_it(Scene(name="post", boxes=(POST,)), crane("mast"), step_hz=240)
    world.command("arm", -1.0, 5.0)
    for _ in range(240):
        world.step()
    world.command("arm", 0.0, 5.0)
    world.command("mast", 1.0, 0.5)
    for _ in range(2 * 240):
        world.step()
    assert world.joint("mast").angle_rad == pytest.approx(2.0, abs=0.01)


@each("on", ["arm", "jib"])
def test_what_hangs_on_nothing_before_it_is_refused(on):
    with pytest.raises(WorldError, match=f"'arm' hangs on '{on}', which is no part before it"):
        to_urdf(crane(on))
