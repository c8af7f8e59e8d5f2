"""Every command that a page shows is one that `hilbench` takes: its options exist, its values can be read, and it runs.

What stands below commands is compared by `test_console_blocks.py` for the pages that are followed word by word.
"""

from __future__ import annotations

import contextlib
import functools
import importlib
import re
import shlex
from collections import Counter
from pathlib import Path

import pytest

from hilbench.cli import COMMANDS, main
from tests.each import each
from tests.packaging import stand_ins

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), *sorted((ROOT / "examples").rglob("*.md"))]
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.DOTALL | re.MULTILINE)
COMMAND = re.compile(r"^\$ hilbench\b(.*)$", re.MULTILINE)
REMARK = re.compile(r" {2,}\S.*| # .*")
"""What stands behind a command to say what it does."""
FILE = re.compile(r"# (\S+\.(?:toml|py))")
"""How a block begins that is a file."""

TUTORIALS = ("ci", "client", "firmware", "protocol")
FOLLOWED = {"README.md", "docs/firmware.md"} | {f"docs/tutorials/{name}.md" for name in TUTORIALS}
"""Pages whose commands are run, and their output compared."""
SERVES = r"^(serve|proxy)\b|--web"
"""Goes on until somebody ends it."""
OPENS = r"^$|^demo\b|^(pioneer|rover|vehicle|my-bench\.toml)\b(?!.*--web)|^replay \S+$"
"""Opens the dashboard."""
AT_A_PORT = r"serial:|socket:|--calibrate"
"""Speaks to what is at a port of the reader's."""
OF_MINUTES = r"^check .*(serial:|socket:|my-(rover|board|dodger)\.)"
"""Runs whole suites for minutes; one clause is run here."""
NOT_RUN = {
    "wants a person, or a client that comes": r"--operator|listen:|--into pty:|^attach",
    "wants several hosts": r"--scheduler",
    "wants a program of the reader's": r"my_(station|bridge)",
    "wants the extra ros2": r"--dds",
    "wants a board of the reader's": r"analyser|new\.elf|^check hilbench.toml --target brain",
}
ELSEWHERE = (
    r"^check (bluepill|rover|vehicle)$|^check rover --json|minimal_client|^run nucleo-f767zi:firmware"
    r"|^check (our_|hilbench\.toml$|pioneer --suite our|echo)"
)
"""Whole suites for minutes, and what needs files of its page: tests of their own run them."""
OLD = "targets/firmware/images/vehicle-v1.elf"
FAILS = {
    "check pioneer -k S36 --set faults.0.kind=drop --set faults.0.probability=0.01",
    "check vehicle-model --target interface.v0=vehicle-model:v1 -k 'VB19 and [v0]'",
    f"check vehicle --target brain.hardened=nucleo-h753zi:{OLD} -k 'VB19 and [hardened]'",
    "check faulty.toml --suite p2os-server --journal run.jsonl",
}
"""Commands whose exit code is 1, as their page says; so is that of each `diff` of two runs that differ."""


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


def is_run_here(line):
    return reason_not_to_run(line) is None and not re.search(ELSEWHERE, line)


RUN = {
    page: lines
    for page, shown in SHOWN.items()
    if page not in FOLLOWED and (lines := [*dict.fromkeys(filter(is_run_here, shown))])
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


def test_most_commands_are_run():
    """The others are listed with a reason; each reason is that of a command."""
    lines = [(page, line) for page, shown in SHOWN.items() for line in shown]
    reasons = Counter(reason_not_to_run(line) for page, line in lines if page not in FOLLOWED)
    assert len(lines) > 100
    assert reasons.keys() == {None, *NOT_RUN}
    not_run = reasons.total() - reasons[None]
    assert not_run < 0.1 * len(lines), reasons


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    stand_ins.record(folder)
    return folder


@pytest.mark.exhaustive("runs what the pages show, for minutes; the gate reads each command")
@pytest.mark.needs_bullet
@pytest.mark.parametrize("page", RUN)
def test_what_a_page_shows_runs(page, recordings, tmp_path, monkeypatch, capfd):
    stand_ins.lay_out(tmp_path, page, recordings)
    for _, text in BLOCK.findall((ROOT / page).read_text(encoding="utf-8")):
        if file := FILE.match(text):
            (tmp_path / file[1]).write_text(text)
    monkeypatch.chdir(tmp_path)
    for line in RUN[page]:
        with contextlib.ExitStack() as stack:
            words = words_of(line)
            if re.search(AT_A_PORT, line):
                words = stack.enter_context(stand_ins.at_stand_ins(line, words, tmp_path))
            code, said = run(line, words, tmp_path), capfd.readouterr().err
            assert code in expected(line), f"{line}\n{said}"


def run(line, words, folder):
    if re.search(SERVES, line):
        return stand_ins.run_until_ready(words, folder)
    if re.search(OPENS, line):
        return stand_ins.open_and_leave(words, folder)
    return main(stand_ins.with_one_clause(line, words) if re.search(OF_MINUTES, line) else words)


def expected(line):
    """Return which exit codes a command may have: at a port the host may be late, and of a host little is known."""
    if re.match(r"doctor --port|udev --check", line):
        return {0, 3}
    if line in FAILS or re.match(r"diff (pins|yesterday)", line):
        return {1}
    if re.search(SERVES, line):  # 130: it was ended before it had begun to wait
        return {0, 130}
    return {0, 1, 4} if re.search(AT_A_PORT, line) else {0}
