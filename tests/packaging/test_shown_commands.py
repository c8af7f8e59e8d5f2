"""Every command that a page shows is one that `hilbench` takes: its options exist, its values can be read, and it runs.

What stands below commands is compared by `test_console_blocks.py` for the pages that are followed word by word.
"""

from __future__ import annotations

import functools
import importlib
import re
import shlex
from pathlib import Path

import pytest

from hilbench.cli import COMMANDS, main
from tests.each import each

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), *sorted((ROOT / "examples").rglob("*.md"))]
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.DOTALL | re.MULTILINE)
COMMAND = re.compile(r"^\$ hilbench\b(.*)$", re.MULTILINE)
REMARK = re.compile(r" {2,}\S.*| # .*")
"""What stands behind a command to say what it does."""
FILE = re.compile(r"# (\S+\.(?:toml|py))")
"""How a block begins that is a file."""

FOLLOWED = {"README.md", "docs/firmware.md", "docs/tutorials/firmware.md"}
"""Pages whose commands are run, and their output compared."""
NOT_RUN = {
    "speaks to a port, a host or a system that a test has not": r"serial:|socket://|tcp://|^ports|^udev|^doctor",
    "opens the dashboard": r"^$|^(pioneer|rover|vehicle|my-bench\.toml)\b|^attach|^replay \S+$",
    "goes on until somebody ends it, or waits for a client": r"^(serve|proxy)\b|listen:|--into pty:",
    "wants an image or a program of the reader's": r"\bmy[-_]|build/|sender|receiver",
    "wants a recording or a bench of the reader's": r"yesterday|live\.|capture\.bin|analyser|session\.|noisy\.toml"
    r"|render run\.|capture:run",
    "is a run of whole suites for minutes, which have tests": r"^check (bluepill|rover|vehicle)$|^check rover --json"
    r"|^report |minimal_client",
    "has a test of its own": r"^run nucleo-f767zi:firmware|^check (our_|hilbench\.toml|pioneer --suite our|echo)",
}
OLD = "targets/firmware/images/vehicle-v1.elf"
FAILS = {
    "check pioneer -k S36 --set faults.0.kind=drop --set faults.0.probability=0.01",
    "check vehicle-model --target interface.v0=vehicle-model:v1 -k 'VB19 and [v0]'",
    f"check vehicle --target brain.hardened=nucleo-h753zi:{OLD} -k 'VB19 and [hardened]'",
    "check faulty.toml --suite p2os-server --journal run.jsonl",
}
"""Commands whose exit code is 1, as their page says; so is that of each `diff` of two benches."""


def shown_in(page):
    """Return the commands of a page, as what stands behind ``hilbench``."""
    blocks = BLOCK.findall(page.read_text(encoding="utf-8"))
    lines = [line for kind, block in blocks if kind in {"", "console", "text"} for line in COMMAND.findall(block)]
    return [REMARK.sub("", line).strip() for line in lines]


SHOWN = {page.relative_to(ROOT).as_posix(): commands for page in PAGES if (commands := shown_in(page))}


def words_of(line):
    return shlex.split(re.split(r"[;|&]", line)[0])


def reason_not_to_run(line):
    return next((reason for reason, pattern in NOT_RUN.items() if re.search(pattern, line)), None)


RUN = {
    page: lines
    for page, shown in SHOWN.items()
    if page not in FOLLOWED and (lines := [line for line in shown if reason_not_to_run(line) is None])
}


@each("page, line", [(page, line) for page, lines in SHOWN.items() for line in lines])
def test_a_command_that_is_shown_can_be_read(page, line, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = words_of(line)
    name = words[0] if words and words[0] in COMMANDS else "dashboard"
    parser_of(name).parse_words(words[name in COMMANDS :])


@functools.cache
def parser_of(name):
    return importlib.import_module(f"hilbench.commands.{name}").parser()


def test_a_third_of_the_commands_are_run():
    """The others want hardware, a person, a file of the reader's, or are suites that have tests."""
    shown = sum(map(len, SHOWN.values()))
    run = sum(len(SHOWN[page]) for page in FOLLOWED) + sum(map(len, RUN.values()))
    assert shown > 100
    assert 3 * run > shown, f"{run} of {shown}"


@pytest.mark.exhaustive("runs what the pages show, for minutes; the gate reads each command")
@pytest.mark.needs_bullet
@pytest.mark.parametrize("page", RUN)
def test_what_a_page_shows_runs(page, tmp_path, monkeypatch, capfd):
    for name in ("targets", "examples"):
        (tmp_path / name).symlink_to(ROOT / name)
    for _, text in BLOCK.findall((ROOT / page).read_text(encoding="utf-8")):
        if file := FILE.match(text):
            (tmp_path / file[1]).write_text(text)
    monkeypatch.chdir(tmp_path)
    for line in RUN[page]:
        code = main(words_of(line))
        assert code == (line in FAILS or line.startswith("diff pins")), f"{line}\n{capfd.readouterr().err}"
