"""docs/firmware.md, done from top to bottom in a folder of one's own: every command gives what stands below it.

In a console block ``$`` begins a command, what follows is its output (both streams), ``...`` in a line stands for any
text, and a line of its own with ``...`` for any lines. A TOML block that begins with a comment is the file of that
name; what is Python is added to the test that `hilbench init` has written.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from tests.hilbench.forked import Forkable

ROOT = Path(__file__).parents[2]
IMAGES = ROOT / "targets/firmware/images"
PAGE = (ROOT / "docs/firmware.md").read_text()
BLOCK = re.compile(r"^```(console|python|toml)\n(.*?)^```", re.DOTALL | re.MULTILINE)
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
    """A shell in a folder with the images, whose `hilbench` and `pytest` are those of this environment."""
    for name, image in FILES.items():
        shutil.copy(IMAGES / image, tmp_path / name)
    tools = tmp_path.parent / f"{tmp_path.name}-bin"
    tools.mkdir()
    for name in ("hilbench", "pytest"):
        (tools / name).write_text(f'#!/bin/sh\nexec "{sys.executable}" -m {name} "$@"\n')
        (tools / name).chmod(0o755)
    environment = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}", "PYTHONPATH": "", "COLUMNS": "80"}
    environment |= {"PYTHONDONTWRITEBYTECODE": "1", "PYTEST_ADDOPTS": ""}

    forkable = Forkable(environment)

    def run(command):
        if command.startswith("hilbench ") and ";" not in command:
            with tempfile.TemporaryFile() as both:
                words = shlex.split(command)[1:]
                forkable.run(*words, cwd=tmp_path, stdout=both.fileno(), stderr=both.fileno())
                both.seek(0)
                return both.read().decode()
        merged = f"exec 2>&1; {command}"
        return subprocess.run(
            ["sh", "-c", merged], cwd=tmp_path, env=environment, capture_output=True, text=True
        ).stdout

    yield run
    forkable.close()


@pytest.mark.exhaustive("a dozen commands and a pytest in turn; the gate has each of them in tests of its own")
def test_the_page_can_be_followed_word_by_word(shell, tmp_path):
    done = 0
    for kind, text in BLOCK.findall(PAGE):
        if kind == "toml":
            (tmp_path / text.split(maxsplit=2)[1]).write_text(text)
        elif kind == "python":
            with (tmp_path / "test_firmware.py").open("a") as file:
                file.write(f"\n\n{text}")
        else:
            for command, shown in commands_of(text):
                said = shell(command)
                assert re.fullmatch(pattern_of(shown), said), f"$ {command}\n{said}"
                done += 1
    assert done >= 10
