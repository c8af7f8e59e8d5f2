"""Boards by name or by file: what comes with hilbench and what a user has written are read in the same way."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hilbench.errors import UsageError
from hilbench.names import file_name
from hilbench.nearest import did_you_mean
from hilbench.schema import json_schema
from hilbench.strict import Strict
from hilbench.toml_file import TomlFile
from targets.boards import BOARD_FOLDER, Board, board_names


def open_board(spec: str, folder: Path, where: str | None = None) -> Board:
    """Return the board that a bench file or a command line means.

    Args:
        spec: name of a built-in board, or the path of a board file, which ends in ``.toml``.
        folder: what the path is relative to.
        where: who names the board, for the error.

    Raises:
        UsageError: there is no such board, or its file is wrong; the line is named.
    """
    if spec in board_names():
        return read_board(BOARD_FOLDER / f"{spec}.toml")
    if not is_board_file(spec):
        hint = did_you_mean(spec, board_names(), "built-in boards")
        raise UsageError(f"no board '{spec}'", where=where, hint=f"{hint} (a file of yours ends in .toml)")
    return read_board(folder / file_name(spec))


def is_board_file(spec: str) -> bool:
    """Say whether a board is meant by its file rather than by its name."""
    return spec.endswith(".toml")


def read_board(path: Path) -> Board:
    """Read a board file; see `open_board`."""
    file = TomlFile(path, "board file")
    return Strict(file.place).convert(file.data, Board)


def board_schema() -> dict[str, Any]:
    """Return the JSON Schema of board files."""
    return json_schema(Board, "hilbench board file")
