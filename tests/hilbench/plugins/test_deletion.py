"""The deletion test: without systems, their suites and protocols the rest is whole, and takes what others bring."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
KEPT = ("hilbench", "protocols", "targets", "worlds", "tests", "measure", "examples", "docs", "udev")
NOT_THERE = ("protocols/p2os", "protocols/pkt", "protocols/carla", "protocols/autoware", "protocols/xrce")
OURS = re.compile(
    r"p2os|pioneer|xrce|\bpkt\b|rover|carla|autoware|vehicle[-_ ]interface|vehicle-|car[-_]host"
    r"|hilbench\.(systems|suites)",
    re.IGNORECASE,
)
ALSO = (
    *("links/test_serialport.py", "mcu/test_init_and_fixtures.py", "mcu/test_lacking.py", "mcu/test_lines.py"),
    *("mcu/test_run.py", "plugins/test_example.py", "plugins/test_new_package.py", "plugins/test_pantilt.py"),
    *("ports/test_odd_machines.py", "check/test_selection.py", "test_world_runner.py"),
)
"""Tests that name one of ours, say as what is not there, and need none."""
NEED_ONE = ("plugins/test_body.py", "plugins/test_derived_mutants.py", "doctor/test_really.py")
"""Tests that need one of ours and do not name it: a folder's `conftest`, a default, what is measured."""
FOLDERS_THAT_NEED_ONE = ("recordings", "suites", "systems")
NOT_HERE = (
    "test_a_board_talks_to_the_virtual_robot or test_what_cannot_be_run_is_said_in_one_line or did_you_mean"
    " or test_it_is_refused_where_it_does_not_belong or test_a_name_that_cannot_be_one_writes_nothing"
)


def generic_tests():
    """Yield the tests that name no system, protocol or suite of ours."""
    yield "tests/worlds"
    yield from (f"tests/hilbench/{name}" for name in ALSO)
    for home in (ROOT / "tests" / "hilbench", ROOT / "tests" / "protocols" / "common"):
        for path in sorted(home.rglob("test_*.py")):
            name = path.relative_to(home)
            left_out = name.parts[0] in FOLDERS_THAT_NEED_ONE or name.as_posix() in (*NEED_ONE, *ALSO)
            if not (left_out or OURS.search(path.read_text(encoding="utf-8"))):
                yield path.relative_to(ROOT).as_posix()


@pytest.fixture(scope="module")
def without(tmp_path_factory):
    """Return a copy without systems, their suites, their protocols, and their entry points."""
    copy = tmp_path_factory.mktemp("deleted")
    for name in KEPT:
        shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__", ".*"))
    for name in ("pyproject.toml", "Makefile", "README.md", "CONTRIBUTING.md"):
        shutil.copy(ROOT / name, copy / name)
    for folder in ("hilbench/systems", "hilbench/suites"):
        shutil.rmtree(copy / folder)
        (copy / folder).mkdir()
        (copy / folder / "__init__.py").touch()
    for folder in NOT_THERE:
        shutil.rmtree(copy / folder)
    about = copy / "hilbench-0.1.0.dist-info"
    about.mkdir()
    about.joinpath("METADATA").write_text("Metadata-Version: 2.1\nName: hilbench\nVersion: 0.1.0\n")
    about.joinpath("entry_points.txt").write_text("[pytest11]\nhilbench = hilbench.pytest_options\n")
    return copy


@pytest.fixture
def run(without):
    def run_there(*words):
        environment = {**os.environ, "PYTHONPATH": str(without)}
        environment.pop("HILBENCH_EXHAUSTIVE", None)
        done = subprocess.run([sys.executable, *words], cwd=without, env=environment, capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr

    return run_there


@pytest.mark.slow("starts three processes in a copy of the tree")
def test_commands_and_a_protocol_of_somebody_else(run):
    code, said = run("-m", "hilbench", "--help")
    assert (code, "usage: hilbench [BENCH]" in said) == (0, True), said
    assert run("-m", "hilbench", "protocols") == (0, "")
    sys_path = "import sys; sys.path.insert(0, 'examples/tank')"
    plugged_in = f"{sys_path}; from hilbench.cli import main; sys.exit(main(['check', 'examples/tank/model.toml']))"
    code, said = run("-c", _with_entry_point(plugged_in))
    assert (code, "exit 0: all checks passed" in said) == (0, True), said


@pytest.mark.exhaustive("some minutes: every test of generic code that names no system, in a copy without any")
def test_all_generic_tests(run):
    code, said = run("-m", "pytest", "-q", "-p", "no:cacheprovider", *generic_tests(), "-k", f"not ({NOT_HERE})")
    assert code == 0, said[-4000:]


def _with_entry_point(program):
    """Let a program find the example as an installed package would be found."""
    return (
        "from importlib import metadata\n"
        "point = metadata.EntryPoint('tank', 'tank.plugin:TANK', 'hilbench.protocols')\n"
        "usual = metadata.entry_points\n"
        "metadata.entry_points = lambda **words: [point] if words == {'group': point.group} else usual(**words)\n"
        f"{program}"
    )
