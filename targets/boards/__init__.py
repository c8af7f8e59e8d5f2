"""Boards: what is soldered around a microcontroller, as data; those that come with hilbench, by name."""

from __future__ import annotations

import tomllib
from pathlib import Path

from targets.boards.board import Board, Button, Connector, Led, Straps
from targets.mcu.errors import BoardError

__all__ = ["BOARD_FOLDER", "Board", "Button", "Connector", "Led", "Straps", "board_names", "built_in_board"]

BOARD_FOLDER = Path(__file__).parent


def board_names() -> tuple[str, ...]:
    """Return the names of the boards that come with hilbench."""
    return tuple(sorted(file.stem for file in BOARD_FOLDER.glob("*.toml")))


def built_in_board(name: str) -> Board:
    """Return a board that comes with hilbench.

    Raises:
        BoardError: there is none of that name.
    """
    if name not in board_names():
        raise BoardError(f"no board '{name}'", hint=f"built-in boards: {', '.join(board_names())}")
    return Board.from_mapping(tomllib.loads((BOARD_FOLDER / f"{name}.toml").read_text(encoding="utf-8")))
