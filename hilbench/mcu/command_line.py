"""Emulated boards on the command line: ``bluepill:IMAGE``, ``./my-board.toml:IMAGE``."""

from __future__ import annotations

from pathlib import Path

from hilbench.bench_file import BenchFile, EmulatedBoard
from hilbench.board_files import is_board_file, open_board
from hilbench.config import built_in_benches, open_bench
from hilbench.errors import UsageError
from hilbench.nearest import did_you_mean
from targets.boards import board_names

__all__ = ["open_target"]


def open_target(what: str | None) -> BenchFile:
    """Return the bench that a command line means: one board with an image, a built-in bench, or a bench file.

    Raises:
        UsageError: there is no such board or bench, or its file is wrong.
        UnavailableError: an image that a bench file names is not there.
    """
    spec, colon, image = (what or "").partition(":")
    is_bench = what in built_in_benches() or not (colon or spec in board_names())
    if what is None or is_bench or Path(what).is_file():
        return open_bench(what)
    if not (spec in board_names() or is_board_file(spec)):
        raise UsageError(f"no board '{spec}'", where=what, hint=did_you_mean(spec, board_names(), "built-in boards"))
    if not image:
        raise UsageError("names no image", where=what, hint=f"write {spec}:IMAGE (ELF, Intel HEX or raw binary)")
    board = open_board(spec, Path())
    emulated = EmulatedBoard(board=board, board_name=spec, firmware=Path(image), straps=board.straps, where=what or "")
    name = Path(spec).stem
    return BenchFile(name=name, path=None, digest="", boards={name: emulated})
