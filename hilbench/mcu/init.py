"""`hilbench init`: a bench file and a first test for firmware of a user's own."""

from __future__ import annotations

import os
from pathlib import Path

from hilbench.benchfile.bench_file import EmulatedBoard
from hilbench.benchfile.board_files import is_board_file, open_board, with_chip
from hilbench.files.names import as_utf8, escaped
from hilbench.files.new_files import Written, quoted, write_new
from hilbench.files.paths import real_path
from hilbench.mcu.images import load

__all__ = ["BENCH_NAME", "CONFTEST_NAME", "TEST_NAME", "init"]

BENCH_NAME = "hilbench.toml"
TEST_NAME = "test_firmware.py"
CONFTEST_NAME = "conftest.py"

PLUGIN = "hilbench.pytest_plugin"

_BENCH = """\
# {image} on a {board_name}. What else can stand here: docs/firmware.md of hilbench.
version = 1

[targets.board]
board = {board}
{chip}firmware = {firmware}
"""

_TEST = '''\
"""What {image} must do, on an emulated {board_name}. Run it with: pytest"""


def test_it_runs_for_a_second_without_a_crash(board):
    board.run(1.0)
    print(*board.transcript, sep="\\n")  # what it said and did; pytest shows it with -s, and when the test fails
    assert board.end is None or board.end.good, str(board.end)
'''

_CONFTEST = '''\
"""Gives the tests beside it and below it what hilbench has for them: `board`, `boards`."""


def pytest_addoption(pluginmanager):
    # As pytest_plugins would do, which pytest allows in the topmost conftest.py only.
    pluginmanager.import_plugin("hilbench.pytest_plugin")
'''
_CONFTEST_IS_THERE = """\
{file} is there already and stays as it is; it needs this line: pytest_plugins = ["hilbench.pytest_plugin"]"""


def init(board: str, image: Path, folder: Path, chip: str | None = None) -> Written:
    """Write a bench file and a test, and have pytest know hilbench.

    Args:
        board: name of a built-in board, or path of a board file.
        image: the firmware.
        folder: where to write; it must exist.
        chip: part number of the chip that the board has instead of its own; None for its own.

    Raises:
        UsageError: no such board, an image that cannot run on it, or a file is there already; nothing is written.
        UnavailableError: no such image.
    """
    opened = open_board(board, Path(), "--board")
    if chip is not None:
        opened = with_chip(opened, chip, "--chip")
    loaded = load(EmulatedBoard(board=opened, board_name=board, firmware=image, straps=opened.straps))
    texts = {
        folder / BENCH_NAME: _BENCH.format(
            image=escaped(image.name),
            board_name=opened.name,
            board=quoted(_seen_from(folder, board) if is_board_file(board) else board),
            chip="" if chip is None else f"chip = {quoted(opened.chip)}\n",
            firmware=quoted(_seen_from(folder, str(image))),
        ),
        folder / TEST_NAME: _TEST.format(image=escaped(image.name).replace('"', "'"), board_name=opened.name),
    }
    notes = list(loaded.notes)
    conftest = folder / CONFTEST_NAME
    if not conftest.exists():
        texts[conftest] = _CONFTEST
    elif PLUGIN not in conftest.read_text(encoding="utf-8", errors="replace"):
        notes.append(_CONFTEST_IS_THERE.format(file=conftest))
    return Written(files=write_new(texts), notes=tuple(notes))


def _seen_from(folder: Path, file: str) -> str:
    return as_utf8(os.path.relpath(real_path(file), real_path(folder)))
