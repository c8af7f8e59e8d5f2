"""Boards that a command line names for built-in benches: what no case would run, or is another board, is refused."""

from __future__ import annotations

import pytest

from hilbench.cli import main
from targets.boards import BOARD_FOLDER
from targets.firmware import image_path

OTHER = image_path("style-registers")


@pytest.mark.parametrize(
    "words", [["--target", f"brain=bluepill:{OTHER}"], ["--target", f"brain.words=bluepill:{OTHER}"]]
)
def test_an_image_that_no_selected_case_runs_is_refused(words, capsys):
    assert main(["check", "bluepill", "--suite", "bluepill-dodge", "-k", "wall", *words]) == 2
    said = capsys.readouterr().err
    assert "no case that is selected runs it; these cases run brain.dodge" in said


@pytest.mark.parametrize(
    ("bench", "name", "wrong", "right"),
    [
        ("rover", "brain.documented", "bluepill", "nucleo-f767zi"),
        ("rover", "brain", "bluepill", "nucleo-f767zi"),
        ("bluepill", "brain.words", "nucleo-f767zi", "bluepill"),
    ],
)
def test_a_board_other_than_that_of_the_bench_is_refused(bench, name, wrong, right, capsys):
    assert main(["check", bench, "--target", f"{name}={wrong}:{OTHER}", "-k", "P01 or G01"]) == 2
    said = f"--target {wrong}:{OTHER}: the board of this bench is {right}, not {wrong}; write {right}:{OTHER}"
    assert capsys.readouterr().err == f"hilbench: {said}\n"


def test_the_board_of_the_bench_may_be_named_by_its_file(capsys):
    words = ["--target", f"brain.words={BOARD_FOLDER / 'bluepill.toml'}:{OTHER}"]
    assert main(["check", "bluepill", "--suite", "bluepill-dodge", "-k", "wall", *words]) == 2
    assert "no case that is selected runs it" in capsys.readouterr().err
