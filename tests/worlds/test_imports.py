"""What is loaded when, and what is said when the physics is not there."""

from __future__ import annotations

import textwrap

from tests.each import each

LIGHT = [
    "worlds",
    "worlds.world",
    "worlds.plane",
    "worlds.bullet",
    "worlds.mujoco",
    "worlds.vehicles.car",
    "worlds.vehicles.pioneer_2dx",
]


def test_importing_loads_neither_numpy_nor_a_physics(python):
    """In one process, one after the other: none loads them, whatever was imported before."""
    run = python(f"""
import importlib, sys
for name in {LIGHT}:
    importlib.import_module(name)
    print(name, sorted({{"mujoco", "numpy", "pybullet"}} & set(sys.modules)))
""")
    assert (run.returncode, run.stdout.splitlines()) == (0, [f"{name} []" for name in LIGHT]), run.stderr


def test_names_and_the_plane_need_no_physics(python):
    run = python(
        textwrap.dedent("""
            import sys
            sys.modules["pybullet"] = sys.modules["mujoco"] = sys.modules["numpy"] = None
            import worlds
            print(worlds.scene_names(), worlds.vehicle_names(), worlds.physics_names())
            world = worlds.open_world("empty", "pioneer-2dx", "plane")
            world.step()
            print(world.step_index)
        """)
    )
    assert run.returncode == 0, run.stderr
    scenes = "'empty', 'wall', 'room-with-boxes', 'corridor', 'ramp', 'post', 'cell', 'stand', 'carpet', 'hard-floor', "
    names = f"({scenes}'rover-room', 'test-track') ('pioneer-2dx', 'rover-4wd', 'car') ('bullet', 'mujoco', 'plane')"
    assert run.stdout.splitlines() == [names, "1"]


@each(
    ("physics", "library", "way_out"),
    [("bullet", "pybullet", 'leave out physics = "bullet"'), ("mujoco", "mujoco", "choose another physics")],
)
def test_without_its_library_one_line_says_what_to_do(python, physics, library, way_out):
    program = """
        import sys
        physics, sys.modules[sys.argv[2]] = sys.argv[1], None
        from worlds import PhysicsMissingError, open_world
        try:
            open_world("empty", "pioneer-2dx", physics)
        except PhysicsMissingError as problem:
            print(problem)
    """
    run = python(textwrap.dedent(program), physics, library)
    assert run.returncode == 0, run.stderr
    (line,) = run.stdout.splitlines()
    assert f"pip install {library}" in line
    assert way_out in line
