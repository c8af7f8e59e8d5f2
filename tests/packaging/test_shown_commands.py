"""Every command that a page shows is one that `hilbench` would take: its options exist and its values can be read.

What it then does is shown by `test_console_blocks.py` for the pages that have output.
"""

from __future__ import annotations

import importlib
import re
import shlex
from pathlib import Path

from hilbench.cli import COMMANDS
from tests.each import each

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), *sorted((ROOT / "examples").rglob("*.md"))]
BLOCK = re.compile(r"^```(?:console|text|)\n(.*?)^```", re.DOTALL | re.MULTILINE)
COMMAND = re.compile(r"^\$ hilbench\b(.*)$", re.MULTILINE)
REMARK = re.compile(r" {2,}\S.*| # .*")
"""What stands behind a command to say what it does."""


def shown_in(page):
    """Return the commands of a page, as words behind ``hilbench``."""
    text = page.read_text(encoding="utf-8")
    return [REMARK.sub("", line) for block in BLOCK.findall(text) for line in COMMAND.findall(block)]


SHOWN = [(page.relative_to(ROOT).as_posix(), line) for page in PAGES for line in shown_in(page)]


@each("page, line", SHOWN)
def test_a_command_that_is_shown_can_be_read(page, line, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = shlex.split(re.split(r"[;|&]", line)[0])
    name = words[0] if words and words[0] in COMMANDS else "dashboard"
    importlib.import_module(f"hilbench.commands.{name}").parser().parse_words(words[name in COMMANDS :])


def test_there_are_commands_to_be_read():
    assert len(SHOWN) > 80
