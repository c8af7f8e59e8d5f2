"""In a working folder that has been removed a command says so in one line: there is nothing wrong with hilbench."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from hilbench.cli import main
from hilbench.doctor.access import look_at_access
from hilbench.doctor.facts import Facts
from hilbench.files.host import Host

ROOT = Path(__file__).parents[2]
IMAGE = str(ROOT / "targets/firmware/images/echo-irq.elf")


@pytest.fixture(autouse=True)
def removed(tmp_path, monkeypatch):
    folder = tmp_path / "removed"
    folder.mkdir()
    monkeypatch.chdir(folder)
    folder.rmdir()


@pytest.mark.parametrize(
    ("words", "where"),
    [
        (["udev", "--check", "--directory", "x"], "x"),
        (["udev", "--install", "--directory", "x"], "x"),
        (["init", "--protocol", "p2os", "--port", "/dev/null"], "test_board.py"),
        (["init", "--board", "bluepill", "--image", IMAGE], "."),
        (["doctor", "--calibrate", "./board"], "./board"),
        (["check", "pioneer-plane", "--list", "--junit", "x"], "x"),
        (["run", f"bluepill:{IMAGE}", "--for", "0.01s", "--journal", "x", "--journal-max", "1MB"], "x"),
        (["proxy", "tcp:0", "tcp:0", "--journal", "x", "--journal-max", "1MB"], "x"),
    ],
    ids=lambda part: " ".join(part[:2]) if isinstance(part, list) else "",
)
def test_what_would_be_in_it_is_refused(words, where, capfd):
    assert main(words) == 3
    out, err = capfd.readouterr()
    hint = "write the path from the root, or go to another folder"
    assert (out, err) == ("", f"hilbench: {where}: the working folder has been removed; {hint}\n")


def test_the_doctor_says_so_of_a_port(tmp_path):
    facts = Facts(host=Host(root=tmp_path), ports=list)
    (found,) = [one for one in look_at_access(facts, "./board@9600") if one.subject == "./board@9600"]
    assert (found.what, found.fix) == (
        "the working folder has been removed",
        "write the path from the root, or go to another folder",
    )


def test_hilbench_starts_in_it():
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-m", "hilbench", "--version"], env=env, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
