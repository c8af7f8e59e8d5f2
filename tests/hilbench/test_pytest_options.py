"""`pytest --hil-bench`: there wherever hilbench is installed, and nothing to anybody who does not ask for it."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from hilbench.pytest_options import add_options
from tests.each import each
from tests.hilbench.forked import ALREADY_IMPORTED, PYTEST

SCALE = "--hil-timeout-scale"
ROOT = Path(__file__).parents[2]
OWN = """
from hilbench.check import case

@case("S01")
def test_echo(peer):
    peer.sync(0)
"""


@pytest.fixture
def plain_pytest(forkable, tmp_path):
    """Run pytest in a folder of its own, with the entry points of hilbench as an installed distribution has them."""
    site = tmp_path / "site"
    about = site / "anybody-1.0.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: anybody\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[pytest11]\nhilbench = hilbench.pytest_options\n")
    folder = tmp_path / "project"
    folder.mkdir()

    def run(*words, test=OWN, forkable=forkable, **more):
        (folder / "test_own.py").write_text(test)
        program = f"import sys\nsys.path[:0] = {[str(site), str(ROOT)]}\n{PYTEST}"
        every = ("-q", "-p", "no:cacheprovider", "-W", "error", *ALREADY_IMPORTED, *words)
        return forkable.run(*every, program=program, cwd=folder, env=more)

    return run


@pytest.mark.parametrize("words", [("--hil-bench",), ("-p", "hilbench.pytest_plugin", "--hilbench-bench")])
def test_a_bench_brings_the_fixtures(plain_pytest, words):
    done = plain_pytest(*words, "pioneer-plane")
    assert "1 passed" in done.output, done.output + done.error


def test_where_plugins_do_not_load_by_themselves(plain_pytest):
    words = ("-p", "hilbench.pytest_plugin", "--hil-bench", "pioneer-plane")
    done = plain_pytest(*words, PYTEST_DISABLE_PLUGIN_AUTOLOAD="1")
    assert "1 passed" in done.output, done.output + done.error


@each(
    ("option", "text", "said"),
    [
        *(
            ("--hil-timeout-scale", text, f"'{text}' is not a factor of 1 to 1000")
            for text in ("0", "-5", "nan", "inf")
        ),
        ("--hil-seed", "-1", f"-1 is not between 0 and {2**63 - 1}"),
        ("--hil-seed", str(2**63), f"{2**63} is not between 0 and {2**63 - 1}"),
        ("--hil-seed", "x", "'x' is not a whole number"),
    ],
)
def test_values_are_those_of_the_command_line(option, text, said):
    readers = {}

    class Group:
        def getgroup(self, _name):
            return self

        def addoption(self, name, *_names, **how):
            readers[name] = how.get("type")

    add_options(Group())
    with pytest.raises(argparse.ArgumentTypeError) as caught:
        readers[option](text)
    assert str(caught.value) == said


def test_a_wrong_value_is_one_line_of_pytest(plain_pytest):
    done = plain_pytest("--hil-bench", "pioneer-plane", "--hil-timeout-scale=nan")
    assert done.returncode == pytest.ExitCode.USAGE_ERROR
    said = "error: argument --hil-timeout-scale/--hilbench-timeout-scale: 'nan' is not a factor of 1 to 1000\n"
    assert said in done.error
    assert "Traceback" not in done.error


def test_who_does_not_ask_for_it_has_none_of_it(plain_pytest, forkable_pytest):
    test = """
import sys

def test_nothing_is_imported():
    there = {name for name in sys.modules if name.partition(".")[0] in {"hilbench", "protocols", "targets", "worlds"}}
    assert there == {"hilbench", "hilbench.pytest_options"}

def test_no_fixture_is_there(request):
    import pytest
    with pytest.raises(pytest.FixtureLookupError):
        request.getfixturevalue("peer")

def test_names_of_ours_are_theirs(world):
    assert world == "flat"

import pytest

@pytest.fixture
def world():
    return "flat"
"""
    done = plain_pytest(test=test, forkable=forkable_pytest)
    assert "3 passed" in done.output, done.output + done.error


def test_the_distribution_has_the_entry_point():
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["entry-points"]["pytest11"] == {"hilbench": "hilbench.pytest_options"}
