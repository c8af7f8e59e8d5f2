"""A part in one line, as ``--part`` has it: ``NAME=KIND``, ``@BUS`` for a part with one bus, ``KEY=VALUE`` by commas.

A key is a terminal, a bus or a setting of the kind, as in a bench file.
"""

from __future__ import annotations

import dataclasses
import tomllib
from typing import Any

from hilbench.benchfile.bench_model import BusPinsEntry, PartEntry
from hilbench.benchfile.wiring_reader import SUPPLIES
from hilbench.errors import UsageError
from hilbench.nearest import did_you_mean
from targets.parts import PARTS, Direction, Part, part_class

__all__ = ["parse_part"]

_EXAMPLE = "write NAME=KIND@BUS,KEY=VALUE, such as display=ssd1306@I2C1 or flash=w25q@SPI1,cs=PA4"


def parse_part(text: str, board: str) -> tuple[str, PartEntry]:
    """Return name and entry of a part at a board.

    Raises:
        UsageError: it is none.
    """
    about, *more = text.split(",")
    name, _, what = about.partition("=")
    kind, at, bus = what.partition("@")
    if not name or not kind:
        raise _error(f"'{text}' is no part", _EXAMPLE)
    own = _buses_of(kind)
    if at and len(own) != 1:
        raise _error(f"a {kind} has {'several buses' if own else 'no bus'}", _EXAMPLE)
    words = {own[0]: bus} if at else {}
    for pair in more:
        key, _, value = pair.partition("=")
        if not key or not value:
            raise _error(f"'{pair}' is not KEY=VALUE", _EXAMPLE)
        words[key] = value
    for missing in (key for key in own if key not in words):
        raise _error(f"{name}: its bus '{missing}' leads nowhere", _EXAMPLE)
    return name, _entry(kind, words, board)


def _buses_of(kind: str) -> tuple[str, ...]:
    if kind not in PARTS:
        raise _error(f"no kind of part '{kind}'", did_you_mean(kind, PARTS, "kinds"))
    part = part_class(kind)
    if any(quantity.needed and quantity.direction is Direction.IN for quantity in part.QUANTITIES):
        hint = "in a bench file: [world], and signals = {...} of the part"
        raise _error(f"a {kind} takes physical values, and there is no world", hint)
    return *part.BUSES, *part.SPI_BUSES


def _entry(kind: str, words: dict[str, str], board: str) -> PartEntry:
    part: type[Part] = part_class(kind)
    buses = (*part.BUSES, *part.SPI_BUSES)
    terminals = [terminal.name for terminal in part.TERMINALS]
    settings = [field.name for field in dataclasses.fields(part.Settings)]
    for key in words:
        if key not in (*buses, *terminals, *settings):
            raise _error(f"a {kind} has no '{key}'", did_you_mean(key, [*buses, *terminals, *settings], "it has"))
    return PartEntry(
        kind=kind,
        pins={key: _of_board(text, board) for key, text in words.items() if key in terminals},
        buses={key: _bus(text, board) for key, text in words.items() if key in buses},
        settings={key: _value(text) for key, text in words.items() if key in settings},
    )


def _bus(text: str, board: str) -> str | BusPinsEntry:
    """Return a bus: ``I2C1``, or ``PB6/PB7`` for SCL and SDA at pins."""
    scl, slash, sda = text.partition("/")
    return BusPinsEntry(scl=_of_board(scl, board), sda=_of_board(sda, board)) if slash else _of_board(text, board)


def _of_board(text: str, board: str) -> str:
    return text if text.lower() in SUPPLIES or "." in text else f"{board}.{text}"


def _value(text: str) -> Any:
    """Read a value as TOML has it; what is none is a text."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def _error(message: str, hint: str | None) -> UsageError:
    return UsageError(message, where="--part", hint=hint)
