"""The deletion test: without systems, their suites and protocols the rest is whole, and takes what others bring."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
KEPT = ("hilbench", "protocols", "targets", "worlds", "tests", "measure", "examples", "docs", "udev")
NOT_THERE = ("protocols/p2os", "protocols/pkt", "protocols/carla", "protocols/autoware")
GENERIC = (
    *("tests/hilbench/links", "tests/hilbench/pace", "tests/hilbench/ports", "tests/hilbench/udev", "tests/worlds"),
    *("tests/hilbench/mcu", "tests/hilbench/wiring", "tests/protocols/common"),
    *(f"tests/hilbench/test_{name}.py" for name in ("clock", "clock_locked", "journal", "devices", "errors", "names")),
    *(f"tests/hilbench/test_{name}.py" for name in ("nearest", "timed_reader", "uncertainty", "world_runner")),
    *(f"tests/hilbench/plugins/test_{name}.py" for name in ("example", "new_package", "page", "pantilt")),
)
ABOUT_SYSTEMS = (
    *("links/test_reconnecting.py", "ports/test_first_test.py", "wiring/test_bench_files.py"),
    *("wiring/test_rover_bench.py", "wiring/test_on_a_board.py", "wiring/test_sensors_on_a_board.py"),
    *("wiring/test_rover_signals.py", "wiring/test_pioneer_signals.py", "wiring/test_car_signals.py"),
    *("mcu/test_run_process.py", "mcu/test_board_provider.py"),
)
"""Tests of generic code that use a system, a protocol or a bench of ours to show it."""
NAME_ONE = (
    "test_a_board_talks_to_the_virtual_robot or test_what_cannot_be_run_is_said_in_one_line or did_you_mean"
    " or test_it_is_refused_where_it_does_not_belong or test_a_name_that_cannot_be_one_writes_nothing"
)


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


@pytest.mark.exhaustive("a minute: every test of generic code that names no system, in a copy without any")
def test_all_generic_tests(run):
    left_out = [word for name in ABOUT_SYSTEMS for word in ("--ignore", f"tests/hilbench/{name}")]
    code, said = run("-m", "pytest", "-q", "-p", "no:cacheprovider", *GENERIC, *left_out, "-k", f"not ({NAME_ONE})")
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
