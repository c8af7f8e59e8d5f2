"""`hilbench init`: a bench file and a first test for firmware of a user's own."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path

from hilbench.bench_file import EmulatedBoard
from hilbench.board_files import is_board_file, open_board
from hilbench.errors import UsageError
from hilbench.files import check_writable, write_atomically
from hilbench.mcu.images import load

__all__ = ["BENCH_NAME", "TEST_NAME", "Written", "init"]

BENCH_NAME = "hilbench.toml"
TEST_NAME = "test_firmware.py"

_BENCH = """\
# {image} on a {board_name}. What else can stand here: docs/firmware.md of hilbench.
version = 1

[targets.board]
board = {board}
firmware = {firmware}
"""

_TEST = '''\
"""What {image} must do, on an emulated {board_name}. Run it with: pytest"""

pytest_plugins = ["hilbench.pytest_plugin"]


def test_it_runs_for_a_second_without_a_crash(board):
    board.run(1.0)
    print(*board.transcript, sep="\\n")  # what it said and did; pytest shows it with -s, and when the test fails
    assert board.end is None or board.end.good, str(board.end)
'''


@dataclass(frozen=True, slots=True, kw_only=True)
class Written:
    """What was written.

    Attributes:
        files: the files.
        notes: what the image is like, for the user to know.
    """

    files: tuple[Path, ...]
    notes: tuple[str, ...]


def init(board: str, image: Path, folder: Path) -> Written:
    """Write a bench file and a test.

    Args:
        board: name of a built-in board, or path of a board file.
        image: the firmware.
        folder: where to write; it must exist.

    Raises:
        UsageError: no such board, an image that cannot run on it, or a file is there already; nothing is written.
        UnavailableError: no such image.
    """
    opened = open_board(board, Path(), "--board")
    loaded = load(EmulatedBoard(board=opened, board_name=board, firmware=image, straps=opened.straps))
    texts = {
        folder / BENCH_NAME: _BENCH.format(
            image=image.name,
            board_name=opened.name,
            board=_quoted(_seen_from(folder, board) if is_board_file(board) else board),
            firmware=_quoted(_seen_from(folder, str(image))),
        ),
        folder / TEST_NAME: _TEST.format(image=image.name.replace('"', "'"), board_name=opened.name),
    }
    for file in texts:
        if file.exists() or file.is_symlink():
            raise UsageError("is there already", where=str(file), hint="remove it, or choose another folder with --dir")
        check_writable(file, "--dir")
    for file, text in texts.items():
        write_atomically(file, text)
    return Written(files=tuple(texts), notes=loaded.notes)


def _seen_from(folder: Path, file: str) -> str:
    return os.path.relpath(Path(file).resolve(), folder.resolve())


def _quoted(text: str) -> str:
    """Return a TOML string; the escapes of JSON are those of TOML."""
    return json.dumps(text, ensure_ascii=False)
