"""Pages that are followed word by word in a folder of one's own: every command gives what stands below it.

In a console block ``$`` begins a command, what follows is its output (both streams), ``...`` in a line stands for any
text, and a line of its own with ``...`` for any lines. A block of TOML or Python that begins with the name of a file in
a comment is that file; other Python is added to the test that `hilbench init` has written.
"""

from __future__ import annotations

import contextlib
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
import serial

from tests.hilbench.forked import Forkable

ROOT = Path(__file__).parents[2]
IMAGES = ROOT / "targets/firmware/images"
BLOCK = re.compile(r"^```(console|python|toml)\n(.*?)^```", re.DOTALL | re.MULTILINE)
FILE = re.compile(r"# (\S+\.(?:toml|py))\n")
FILES = {
    "firmware.elf": "style-irq-dma.elf",
    "jump-erased.elf": "bad-jump-erased.elf",
    "stuck.elf": "bad-stuck.elf",
    "selftest-rcc.elf": "selftest-rcc.elf",
    "style-kernel.elf": "style-kernel.elf",
}


def pattern_of(shown):
    """Return the pattern that output must match which is shown like this."""
    return "".join(map(_line_pattern, shown.splitlines()))


def _line_pattern(line):
    return r"(.*\n)*" if line == "..." else ".*".join(map(re.escape, line.split("..."))) + "\n"


def commands_of(block):
    """Return each command with the output that is shown for it."""
    return [tuple(part.split("\n", 1)) for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]]


@pytest.fixture
def shell(tmp_path):
    """A shell in the folder ``try`` of a checkout, whose `hilbench` and `pytest` are those of this environment."""
    for name in ("targets", "examples"):
        (tmp_path / name).symlink_to(ROOT / name)
    folder = tmp_path / "try"
    folder.mkdir()
    tools = tmp_path / "bin"
    tools.mkdir()
    for name, module in (("hilbench", "-m hilbench"), ("pytest", "-m pytest"), ("python", "")):
        (tools / name).write_text(f'#!/bin/sh\nexec "{sys.executable}" {module} "$@"\n')
        (tools / name).chmod(0o755)
    environment = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}", "PYTHONPATH": "", "COLUMNS": "80"}
    environment |= {"PYTHONDONTWRITEBYTECODE": "1", "PYTEST_ADDOPTS": ""}

    forkable = Forkable(environment)

    def run(command):
        if command.startswith("hilbench ") and ";" not in command:
            with tempfile.TemporaryFile() as both:
                words = shlex.split(command)[1:]
                forkable.run(*words, cwd=folder, stdout=both.fileno(), stderr=both.fileno())
                both.seek(0)
                return both.read().decode()
        merged = f"exec 2>&1; {command}"
        return subprocess.run(["sh", "-c", merged], cwd=folder, env=environment, capture_output=True, text=True).stdout

    yield run
    forkable.close()


def follow(page, shell, folder):
    """Do what a page says, block by block; return how many commands that were."""
    done = 0
    for kind, text in BLOCK.findall((ROOT / page).read_text()):
        if kind != "console" and (file := FILE.match(text)):
            (folder / file[1]).write_text(text)
        elif kind == "python":
            with (folder / "test_firmware.py").open("a") as file:
                file.write(f"\n\n{text}")
        else:
            for command, shown in commands_of(text):
                said = shell(command)
                assert re.fullmatch(pattern_of(shown), said), f"$ {command}\n{said}"
                done += 1
    return done


@pytest.mark.exhaustive("a dozen commands and a pytest in turn; the gate has each of them in tests of its own")
def test_the_page_on_firmware_can_be_followed(shell, tmp_path):
    folder = tmp_path / "try"
    for name, image in FILES.items():
        shutil.copy(IMAGES / image, folder / name)
    assert follow("docs/firmware.md", shell, folder) >= 10


@pytest.mark.exhaustive("eight commands and a pytest in turn; the gate has each of them in tests of its own")
def test_the_tutorial_on_firmware_can_be_followed(shell, tmp_path):
    assert follow("docs/tutorials/firmware.md", shell, tmp_path / "try") >= 7


@pytest.mark.exhaustive("a dozen commands in turn; the gate has tests of what they do")
@pytest.mark.parametrize(("page", "commands"), [("protocol", 4), ("client", 5), ("ci", 4)])
def test_the_other_tutorials_can_be_followed(page, commands, shell, tmp_path):
    assert follow(f"docs/tutorials/{page}.md", shell, tmp_path / "try") == commands


@pytest.mark.exhaustive("an emulated rover in its world; the gate has a mutant for the same clause")
@pytest.mark.needs_bullet
def test_the_readme_shows_a_defect_that_is_found(shell, tmp_path):
    (tmp_path / "try/targets").symlink_to(ROOT / "targets")
    text, *_ = (text for kind, text in BLOCK.findall((ROOT / "README.md").read_text()) if kind == "console")
    ((command, shown),) = commands_of(text)
    said = shell(command)
    assert re.fullmatch(pattern_of(shown), said), f"$ {command}\n{said}"


@pytest.mark.exhaustive("a process in real time; the gate has tests of `serve` itself")
def test_the_serial_port_of_the_tutorial_answers(tmp_path):
    page = (ROOT / "docs/tutorials/firmware.md").read_text()
    command, shown = re.search(r"^\$ (hilbench serve .*)\n((?:.*\n)*?)```", page, re.MULTILINE).groups()
    shutil.copy(IMAGES / FILES["firmware.elf"], tmp_path / "firmware.elf")
    words = [sys.executable, "-m", *shlex.split(command)]
    with (
        subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as served,
        contextlib.ExitStack() as at_end,
    ):
        at_end.callback(served.kill)
        for line in shown.splitlines():
            assert re.fullmatch(re.escape(line).replace("pts/1", r"pts/\d+"), served.stderr.readline().rstrip("\n"))
        said = b""
        with serial.Serial(str(tmp_path / "u1"), 115200, timeout=1) as port:
            for _ in range(60):  # what comes before the firmware has its USART on is lost
                port.write(b"count\r\n")
                said += port.read_until(b"presses 0")
                if b"presses 0" in said:
                    break
        assert re.search(rb"bytes \d+ ticks \d+ presses 0", said)
        served.send_signal(signal.SIGINT)
        served.stderr.read()
        assert served.wait() == 0
