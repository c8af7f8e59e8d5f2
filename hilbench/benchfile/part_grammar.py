"""A part in one line, as ``--part`` has it: ``NAME=KIND``, ``@BUS`` for a part with one bus, ``KEY=VALUE`` by commas.

A key is a terminal, a bus or a setting of the kind, as in a bench file. Pins may be in small letters, as buses may.
"""

from __future__ import annotations

import dataclasses
import tomllib
from collections.abc import Callable
from functools import partial
from typing import Any

from hilbench.benchfile.bench_model import BusPinsEntry, PartEntry
from hilbench.benchfile.wiring_reader import SUPPLIES
from hilbench.errors import UsageError
from hilbench.nearest import did_you_mean
from targets.boards import Board
from targets.parts import PARTS, Direction, Part, part_class

__all__ = ["parse_part"]

_EXAMPLE = "write NAME=KIND@BUS,KEY=VALUE, such as display=ssd1306@I2C1 or flash=w25q@SPI1,cs=PA4"


def parse_part(text: str, board_name: str, board: Board) -> tuple[str, PartEntry]:
    """Return name and entry of a part at a board.

    Args:
        text: the line.
        board_name: what the board is called on its bench.
        board: the board.

    Raises:
        UsageError: it is none.
    """
    if "\n" in text or "\r" in text:
        raise _error(f"{text!r} has a line break", "write a part in one line")
    about, *more = text.split(",")
    name, _, what = about.partition("=")
    kind, at, bus = what.partition("@")
    if not name or not kind:
        raise _error(f"'{text}' is no part", _EXAMPLE)
    if "." in name:
        raise _error(f"'{name}': a name of a part has no dot", f"write {name.replace('.', '_')}={what}")
    own = _buses_of(kind)
    if at and len(own) != 1:
        raise _error(f"a {kind} has {'several buses' if own else 'no bus'}", _EXAMPLE)
    words = {own[0]: bus} if at else {}
    for pair in more:
        key, _, value = pair.partition("=")
        if not key or not value:
            raise _error(f"'{pair}' is not KEY=VALUE", _EXAMPLE)
        if key in words:
            raise _error(f"{name}: '{key}' is given twice", "say it once")
        words[key] = value
    for missing in (key for key in own if key not in words):
        raise _error(f"{name}: its bus '{missing}' leads nowhere", _EXAMPLE)
    return name, _entry(kind, words, partial(_end, board_name, board))


def _buses_of(kind: str) -> tuple[str, ...]:
    if kind not in PARTS:
        raise _error(f"no kind of part '{kind}'", did_you_mean(kind, PARTS, "kinds"))
    part = part_class(kind)
    if any(quantity.needed and quantity.direction is Direction.IN for quantity in part.QUANTITIES):
        hint = "in a bench file: [world], and signals = {...} of the part"
        raise _error(f"a {kind} takes physical values, and there is no world", hint)
    return *part.BUSES, *part.SPI_BUSES


def _entry(kind: str, words: dict[str, str], end: Callable[[str], str]) -> PartEntry:
    part: type[Part] = part_class(kind)
    buses = (*part.BUSES, *part.SPI_BUSES)
    terminals = [terminal.name for terminal in part.TERMINALS]
    settings = [field.name for field in dataclasses.fields(part.Settings)]
    for key in words:
        if key not in (*buses, *terminals, *settings):
            raise _error(f"a {kind} has no '{key}'", did_you_mean(key, [*buses, *terminals, *settings], "it has"))
    return PartEntry(
        kind=kind,
        pins={key: end(text) for key, text in words.items() if key in terminals},
        buses={key: _bus(text, end) for key, text in words.items() if key in buses},
        settings={key: _value(text) for key, text in words.items() if key in settings},
    )


def _bus(text: str, end: Callable[[str], str]) -> str | BusPinsEntry:
    """Return a bus: ``I2C1``, or ``PB6/PB7`` for SCL and SDA at pins."""
    if "/" not in text:
        return end(text)
    pins = text.split("/")
    if len(pins) != 2 or not all(pins):
        raise _error(f"'{text}' is not two pins", "write SCL/SDA, such as PB6/PB7")
    return BusPinsEntry(scl=end(pins[0]), sda=end(pins[1]))


def _end(board_name: str, board: Board, text: str) -> str:
    """Return an end of a wire as a bench file has it; without a dot it is the board's."""
    if text.lower() in SUPPLIES or "." in text:
        return text
    small = board.port_pin(text) is None and board.port_pin(text.upper()) is not None
    return f"{board_name}.{text.upper() if small else text}"


def _value(text: str) -> Any:
    """Read a value as TOML has it; what is none is a text, and whole: nothing behind a value or a ``#`` is cut off."""
    try:
        value, _end = tomllib.loads(f"value = [{text}, 0]")["value"]
    except (ValueError, RecursionError):  # no TOML, or not one value and the end
        return text
    return value


def _error(message: str, hint: str | None) -> UsageError:
    return UsageError(message, where="--part", hint=hint)
