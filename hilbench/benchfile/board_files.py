"""Boards by name or by file: what comes with hilbench and what a user has written are read in the same way."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from pathlib import Path
from typing import Any, get_args

from hilbench.errors import UsageError
from hilbench.files.names import file_name
from hilbench.nearest import did_you_mean
from hilbench.strict import Strict
from hilbench.strict.schema import json_schema
from hilbench.strict.toml_file import TomlFile
from targets.boards import BOARD_FOLDER, Board, board_names
from targets.mcu.variants import VARIANTS, ChipName

_PACKAGES = "TCRVZI"
"""The letters of packages in part numbers of ST, by the number of pins: 36, 48, 64, 100, 144, 176."""


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


def with_chip(board: Board, chip: str, where: str | None = None) -> Board:
    """Return a board with another chip of the same family in the place of its own; what that lacks leads nowhere.

    Args:
        board: the board.
        chip: part number.
        where: who names the chip, for the error.

    Raises:
        UsageError: there is no such chip, or it does not have a pin that the board uses.
    """
    known: tuple[ChipName, ...] = get_args(ChipName)
    family = {str(name): name for name in known if VARIANTS[name].family == board.variant.family}
    instead = family.get(chip.upper())
    if instead is None:
        near = _as_large(chip.upper(), family)
        hint = f"did you mean '{near}'?" if near else did_you_mean(chip, family, "chips")
        raise UsageError(f"no chip '{chip}' that could take the place of the {board.chip}", where=where, hint=hint)
    usarts = VARIANTS[instead].usarts
    connectors = tuple(
        dataclasses.replace(one, usarts=tuple(usart for usart in one.usarts if usart in usarts))
        for one in board.connectors
    )
    try:
        return dataclasses.replace(board, chip=instead, connectors=connectors)
    except ValueError as error:
        raise UsageError(f"does not fit the board: {error}", where=where) from None


def _as_large(chip: str, family: Iterable[str]) -> str | None:
    """Return the chip of the same line and as much flash whose package is nearest, the larger of two; None for none."""
    line, place, flash = chip[:9], _PACKAGES.find(chip[9:10] or "?"), chip[10:11]  # STM32F103, C, E
    there = [one for one in family if place >= 0 and one[:9] == line and one[10:] == flash]
    further = {one: _PACKAGES.find(one[9]) - place for one in there}
    return min(there, key=lambda one: (abs(further[one]), further[one] < 0), default=None)


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
