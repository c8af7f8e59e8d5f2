"""Which image a case runs: what none would run is refused; a board without a program of that name keeps its own."""

from __future__ import annotations

import json

import pytest

from hilbench.cli import main
from targets.firmware import image_path
from worlds import default_physics

OURS = image_path("robot-dodge")
OTHER = image_path("style-registers")

SUITE = """
from hilbench.check import CaseSetup, case

@case("X1", text="The program runs.", source="here", setup=CaseSetup(program="words"))
def test_program(bench):
    assert {name: str(board.emulated.bench_file.boards[name].firmware) for name, board in bench.boards.items()} == FILES
"""

BENCH = """
version = 1
suites = ["suite.py"]
[targets.first]
board = "bluepill"
firmware = '{ours}'
[targets.first.programs]
words = '{ours}'
[targets.second]
board = "bluepill"
firmware = '{other}'
"""


def test_the_board_of_the_bench_may_have_another_chip(tmp_path, capsys):
    text = BENCH.format(ours=OURS, other=OTHER).replace(
        'board = "bluepill"', 'board = "bluepill"\nchip = "STM32F103CB"'
    )
    (tmp_path / "own.toml").write_text(text)
    (tmp_path / "suite.py").write_text(f"FILES = {{'first': '{OTHER}', 'second': '{OTHER}'}}\n{SUITE}")
    words = ["--target", f"first.words=bluepill:{OTHER}"]
    assert main(["check", str(tmp_path / "own.toml"), *words]) == 0, capsys.readouterr().err


def test_a_firmware_that_no_selected_case_runs_is_refused(tmp_path, capsys):
    text = BENCH.format(ours=OURS, other=OTHER).replace(str(OURS), str(OTHER), 1)
    (tmp_path / "own.toml").write_text(text)
    (tmp_path / "suite.py").write_text(f"FILES = {{}}\n{SUITE}")
    assert main(["check", str(tmp_path / "own.toml")]) == 2
    said = capsys.readouterr().err
    assert f"own.toml:6: no case that is selected runs the firmware '{OTHER}'" in said
    assert "these cases run first.words, second; see [targets.first.programs]" in said


def test_a_board_without_a_program_of_that_name_runs_its_firmware(tmp_path, capsys):
    (tmp_path / "bench.toml").write_text(BENCH.format(ours=OURS, other=OTHER))
    files = {"first": str(OURS), "second": str(OTHER)}
    (tmp_path / "suite.py").write_text(f"FILES = {files!r}\n{SUITE}")
    assert main(["check", str(tmp_path / "bench.toml")]) == 0, capsys.readouterr()


def test_a_variant_without_the_program_makes_a_case_not_applicable(tmp_path, capsys):
    (tmp_path / "bench.toml").write_text(BENCH.format(ours=OURS, other=OTHER))
    base = BENCH.format(ours=OURS, other=OTHER) + '[variants]\nthere = "bench.toml"\n'
    (tmp_path / "base.toml").write_text(base)
    suite = SUITE.replace('program="words"', 'program="dodge", variant="there"')
    (tmp_path / "suite.py").write_text(f"FILES = {{}}\n{suite}")
    assert main(["check", str(tmp_path / "base.toml")]) == 4
    assert "n/a" in capsys.readouterr().out


WORLD = """
[world]
vehicle = "pioneer-2dx"
scene = "empty"
{physics}
[parts.motor]
kind = "motor-code"
pins = {{ comm1 = "first.PB7", comm2 = "first.PB6", comm3 = "first.PB5" }}
signals = {{ speed = "world.wheel_left" }}
"""
OF_THERE = """
from hilbench.check import CaseSetup, case

@case("X1", text="It has a physics.", source="here", setup=CaseSetup(variant="there"))
def test_physics(bench):
    assert [board.emulated.bench_file.world.physics for board in bench.boards.values()] == ["{physics}"] * 2
"""


@pytest.mark.needs_physics
@pytest.mark.parametrize(("words", "set_too"), [([], False), (["--set", "world.physics=plane"], True)])
def test_a_physics_that_is_set_is_that_of_the_variants_too(tmp_path, capsys, words, set_too):
    board, report = BENCH.format(ours=OURS, other=OTHER), tmp_path / "report.json"
    (tmp_path / "there.toml").write_text(board + WORLD.format(physics=""))
    own = WORLD.format(physics='physics = "plane"')
    (tmp_path / "base.toml").write_text(f'{board}{own}[variants]\nthere = "there.toml"\n')
    (tmp_path / "suite.py").write_text(OF_THERE.format(physics="plane" if set_too else default_physics()))
    assert main(["check", str(tmp_path / "base.toml"), "--json", str(report), *words]) == 0, capsys.readouterr()
    about = json.loads(report.read_text())["bench"]
    assert about["physics"].startswith("plane at 240 Hz")
    assert about.get("physics of there", "").startswith("" if set_too else f"{default_physics()} (")
    assert ("physics of there" in about) is not set_too
