"""A physics that has lost its vehicle says so in one line, and where it last was; it leaves no other trace."""

from __future__ import annotations

import math
import re
import sys
import textwrap

import pytest

from tests.rigid import MUJOCO, push
from worlds import WorldError
from worlds.vehicles.pioneer_2dx import LEFT


@pytest.mark.parametrize("read", ["pose", "velocity", "joint"])
def test_bad_numbers_end_a_run_with_the_last_good_place(open_it, physics, read):
    world = open_it("empty", "pioneer-2dx")
    world.place(1.0, 2.0, 0.5)
    for _ in range(10):
        world.step()
    world.pose()
    push(world, (math.nan, 0.0, 0.0))
    with pytest.raises(WorldError) as caught:
        for _ in range(3):
            world.step()
            world.joint(LEFT) if read == "joint" else getattr(world, read)()
    with pytest.raises(WorldError):  # and it does not say a number when asked again
        world.joint(LEFT) if read == "joint" else getattr(world, read)()
    said = str(caught.value)
    assert "\n" not in said
    assert re.match(f"physics '{physics}' lost the 'pioneer-2dx' in step 1[0-3]: ", said)
    assert "last seen in step 10 at x 1.000 m, y 2.000 m, z " in said


@pytest.mark.parametrize("physics", [MUJOCO])
def test_mujoco_s_own_warnings_are_an_error_in_the_step_itself(open_it):
    world = open_it("empty", "pioneer-2dx")
    push(world, (math.nan, 0.0, 0.0))
    with pytest.raises(WorldError, match="Nan, Inf or huge value in QVEL"):
        world.step()
    other = open_it("empty", "pioneer-2dx")
    other.step()
    assert math.isfinite(other.pose().yaw_rad)


@pytest.mark.needs_mujoco
def test_mujoco_writes_neither_a_file_nor_a_word(python, tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", ":".join(sys.path))
    monkeypatch.chdir(tmp_path)
    program = """
        from worlds import WorldError, open_world
        world = open_world("empty", "pioneer-2dx", "mujoco")
        world._data.qvel[0] = float("nan")
        try:
            world.step()
        except WorldError:
            print("lost")
    """
    run = python(textwrap.dedent(program))
    assert (run.returncode, run.stdout, run.stderr) == (0, "lost\n", "")
    assert list(tmp_path.iterdir()) == []
