"""Which physics a bench runs on: always named, never silently another one."""

from __future__ import annotations

import importlib.util
import json
import math

import pytest

from hilbench.bench.physics import describe_physics, physics_capabilities
from hilbench.cli import main
from hilbench.journal.run_hash import run_hash
from tests.each import each
from worlds import default_physics, engine_of, physics_is_there
from worlds.world import open_world

BENCH = """\
version = 1
suites = ["p2os-server"]
[world]
{physics}
[targets.robot]
model = "pioneer-2dx"
[[links]]
ends = ["peer", "robot.host"]
baud = 9600
"""
MUJOCO = 'physics = "mujoco"'


@pytest.fixture
def check(tmp_path, capfd, monkeypatch):
    """Check the watchdog on a bench with these words about its physics; return code, report, stdout and stderr."""
    monkeypatch.chdir(tmp_path)

    def run(words):
        (tmp_path / "bench.toml").write_text(BENCH.format(physics=words))
        code = main(["check", "bench.toml", "-k", "S36", "--json", "report.json", "--journal", "run.journal"])
        out, err = capfd.readouterr()
        report = json.loads((tmp_path / "report.json").read_text()) if code == 0 else {}
        return code, report, out, err

    return run


@pytest.fixture
def journal(tmp_path):
    """Read the header of the journal."""
    return lambda: json.loads((tmp_path / "run.journal").read_text().splitlines()[0])


@pytest.fixture
def without(monkeypatch):
    """Hide libraries."""
    find_spec = importlib.util.find_spec

    def hide(*names):
        monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name in names else find_spec(name))

    return hide


@pytest.mark.needs_mujoco
@pytest.mark.usefixtures("keep_signals")
def test_a_bench_runs_on_mujoco_says_so_and_has_the_same_hash_again(check, journal):
    code, report, out, _ = check(MUJOCO)
    assert (code, report["bench"]["physics"]) == (0, f"mujoco ({engine_of('mujoco')}) at 240 Hz")
    assert report["bench"]["physics"] in out.splitlines()[0]
    assert journal()["physics"] == {"name": "mujoco", "engine": engine_of("mujoco"), "step_hz": 240}
    assert check(MUJOCO)[1]["run_hash"] == report["run_hash"]


@pytest.mark.needs_physics
@pytest.mark.usefixtures("keep_signals")
def test_a_world_whose_numbers_end_ends_a_case_with_the_last_good_place(check, monkeypatch):
    kind = type(open_world("empty", "pioneer-2dx"))
    read = kind._read_place

    def lost(world):
        place, turned = read(world)
        return (math.nan if world.step_index > 100 else place[0], *place[1:]), turned

    monkeypatch.setattr(kind, "_read_place", lost)
    code, _, out, _ = check("")
    assert code == 3
    (cause,) = (line for line in out.splitlines() if line.startswith("  cause"))
    assert "lost the 'pioneer-2dx' in step 101" in cause
    assert "last seen in step 100 at x 0.00" in cause
    assert "Traceback" not in out


@pytest.mark.parametrize(
    ("hidden", "words", "said"),
    [
        (("pybullet",), 'physics = "bullet"', 'PyBullet is not installed; leave out physics = "bullet"'),
        (("pybullet", "mujoco"), "", "physics = \"mujoco\": MuJoCo is not installed; pip install 'hilbench[mujoco]'"),
    ],
)
@pytest.mark.usefixtures("keep_signals")
def test_a_library_that_is_missing_is_one_line_and_exit_3(check, without, hidden, words, said):
    without(*hidden)
    if "mujoco" not in hidden and not physics_is_there("mujoco"):
        pytest.skip("mujoco is not installed")
    code, _, out, err = check(words)
    assert (code, out) == (3, "")
    (line,) = err.splitlines()
    assert said in line


def test_the_default_is_pybullet_where_it_is_and_mujoco_elsewhere(without):
    without("nothing")
    there = physics_is_there("bullet")
    assert default_physics() == ("bullet" if there else "mujoco")
    without("pybullet")
    assert (default_physics(), engine_of("bullet")) == ("mujoco", "PyBullet, not installed")


@each(
    ("physics", "named"),
    [
        ("none", False),
        ("plane at 240 Hz", False),
        ("bullet (PyBullet 3.2.7) at 240 Hz", False),
        ("bullet (PyBullet 3.2.8) at 240 Hz", True),
        ("mujoco (MuJoCo 4.0.1) at 240 Hz", True),
    ],
)
def test_the_run_hash_names_the_physics_but_for_those_it_never_named(physics, named):
    assert (run_hash({"a": "00"}, physics) != run_hash({"a": "00"}, "none")) is named
    assert run_hash({}, physics) is None


@pytest.mark.parametrize(
    "physics",
    [
        pytest.param("bullet", marks=pytest.mark.needs_bullet),
        pytest.param("mujoco", marks=pytest.mark.needs_mujoco),
        "plane",
    ],
)
def test_what_is_said_without_opening_a_world_is_true_of_one(physics):
    world = open_world("empty", "pioneer-2dx", physics)
    assert (world.name, world.capabilities) == (physics, physics_capabilities(physics))
    assert describe_physics(physics, 240).startswith(physics)
    world.close()
