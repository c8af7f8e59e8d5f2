"""docs/plugins.md: what it writes down runs."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

from hilbench.benchfile.reader import open_bench
from hilbench.serving.served_model import served_target

PAGE = (Path(__file__).parents[3] / "docs" / "plugins.md").read_text()
FILES = dict(re.findall(r"```(?:python|toml)\n# (\S+)\n(.*?)```", PAGE, re.DOTALL))
DECODED = re.search(r"\$ echo ([0-9A-F ]+) \| hilbench (decode .*?)\n(.*?)```", PAGE, re.DOTALL)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return a folder with the files of the page."""
    for name, text in FILES.items():
        tmp_path.joinpath(name).write_text(text)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_page_has_its_files():
    assert list(FILES) == [
        "tiny.py",
        "crc.py",
        "echo.py",
        "test_echo.py",
        "echo.toml",
        "turn.py",
        "test_turn.py",
        "turn.toml",
    ]


def test_its_frames_are_decoded_as_it_shows(hilbench, folder):
    data, command, shown = DECODED.groups()
    folder.joinpath("line.hex").write_text(data)
    words = command.split()
    code, out, err = hilbench(*words[:2], "line.hex", *words[2:])
    assert code == 1
    assert out + err == shown


def test_its_crc_is_as_it_says(folder):
    runpy.run_path(str(folder / "crc.py"))  # it asserts a frame


def test_its_bench_is_checked_and_its_rule_finds_what_breaks_it(hilbench, folder):
    code, out, err = hilbench("check", "echo.toml")
    assert code == 0, out + err
    assert "ECHO1   must   pass" in out


def test_its_rule_finds_what_breaks_it(hilbench, folder):
    folder.joinpath("echo.py").write_text(
        FILES["echo.py"].replace("found.raw for", 'found.raw.replace(b"l", b"r") for')
    )
    code, out, err = hilbench("check", "echo.toml")
    assert code == 1, out + err
    assert "ECHO1   must   fail" in out


def test_what_came_before_a_failure_is_shown_in_words(hilbench, folder):
    folder.joinpath("test_echo.py").write_text(FILES["test_echo.py"].replace('== b"hello"', '== b"olleh"'))
    code, out, err = hilbench("check", "echo.toml")
    assert code == 1, out + err
    assert "s  <  Tiny payload=68 65 6C 6C 6F  [05 68 65 6C 6C 6F 19]" in out


def test_its_model_is_listed(hilbench, folder):
    code, out, _ = hilbench("protocols", "--plugin", "echo.py")
    assert code == 0
    assert out.splitlines()[-1].startswith("echo")


@pytest.mark.needs_physics
def test_its_system_is_checked_in_a_world_and_served(hilbench, folder):
    code, out, err = hilbench("check", "turn.toml")
    assert code == 0, out + err
    assert "TURN1   must   pass" in out
    assert served_target(open_bench("turn.toml")).lines == {"host": 9600}


@pytest.mark.needs_physics
def test_its_rule_finds_a_plate_that_turns_too_slowly(hilbench, folder):
    folder.joinpath("turn.py").write_text(FILES["turn.py"].replace("/ 100", "/ 110"))
    code, out, err = hilbench("check", "turn.toml")
    assert code == 1, out + err
    assert "TURN1   must   fail" in out
