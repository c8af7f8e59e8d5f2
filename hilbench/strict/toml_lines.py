"""Finds the line of a key in TOML text, or of an entry of a list; `tomllib` does not say where values stood.

Reads just enough of TOML for that: headers, keys, entries, and where a value ends. It is only asked about text that
`tomllib` has accepted, so it need not recognise errors.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Sequence
from dataclasses import dataclass

Path = tuple[str | int, ...]

_KEY_PART = r"""[A-Za-z0-9_-]+|"(?:[^"\\]|\\.)*"|'[^']*'"""
_KEY = re.compile(rf"\s*((?:{_KEY_PART})(?:\s*\.\s*(?:{_KEY_PART}))*)\s*=")
_HEADER = re.compile(rf"\s*(\[\[?)\s*((?:{_KEY_PART})(?:\s*\.\s*(?:{_KEY_PART}))*)\s*\]\]?")
_PART = re.compile(_KEY_PART)

# What may stand in a value, longest first: strings whole, so that brackets and hashes in them do not count.
_VALUE_TOKEN = re.compile(
    r'"""(?:[^\\]|\\.)*?"{3,5}' r"|'''.*?'{3,5}" r'|"(?:[^"\\\n]|\\.)*"' r"|'[^'\n]*'" r"|#[^\n]*" r"|[\[{]|[\]}]|\n|.",
    re.DOTALL,
)


def find_line(text: str, path: Sequence[str | int]) -> int | None:
    """Return the number of the line, from 1, where a key stands, or failing that the table it would be in.

    Args:
        text: TOML text.
        path: keys, and indices from 0 in lists and arrays of tables. What is in an inline table has the line of that.
    """
    lines = _lines(text)
    for length in range(len(path), 0, -1):
        line = lines.get(tuple(path[:length]))
        if line is not None:
            return line
    return None


@functools.lru_cache(maxsize=4)  # a file is asked about several of its keys
def _lines(text: str) -> dict[Path, int]:
    found: dict[Path, int] = {}
    arrays: dict[Path, int] = {}
    table: Path = ()
    at = 0
    while at < len(text):
        line = text.count("\n", 0, at) + 1
        if header := _HEADER.match(_line_at(text, at)):
            table = _opened(_parts(header[2]), arrays, repeated=header[1] == "[[")
            _enter(found, (), table, line)
            at = _next_line(text, at)
        elif key := _KEY.match(_line_at(text, at)):
            _enter(found, table, _parts(key[1]), line)
            at = _after_value(text, at + key.end(), line, (*table, *_parts(key[1])), found)
        else:
            at = _next_line(text, at)
    return found


def _enter(found: dict[Path, int], table: Path, keys: Path, line: int) -> None:
    for length in range(1, len(keys) + 1):
        found.setdefault((*table, *keys[:length]), line)


def _opened(keys: Path, arrays: dict[Path, int], *, repeated: bool) -> Path:
    """Return the path of the table that a header opens, with the indices of the arrays of tables it is in."""
    path: Path = ()
    for number, key in enumerate(keys, 1):
        path = (*path, key)
        if repeated and number == len(keys):
            arrays[path] = arrays.get(path, -1) + 1
        if path in arrays:
            path = (*path, arrays[path])
    return path


def _parts(dotted: str) -> Path:
    return tuple(part.strip("\"'") for part in _PART.findall(dotted))


def _line_at(text: str, at: int) -> str:
    return text[at : _next_line(text, at)]


def _next_line(text: str, at: int) -> int:
    end = text.find("\n", at)
    return len(text) if end < 0 else end + 1


@dataclass
class _Open:
    """A list or an inline table whose end is still to come.

    Attributes:
        path: that of a list; None for a table, and for all that is in one.
        entry: the index of the entry that is read.
        awaited: that entry has not begun yet.
    """

    path: Path | None
    entry: int = 0
    awaited: bool = True

    def inner(self) -> Path | None:
        """Return the path of the present entry."""
        return None if self.path is None else (*self.path, self.entry)


def _after_value(text: str, at: int, line: int, path: Path, found: dict[Path, int]) -> int:
    """Return where a value that begins in a line has ended with its line; enter the lines of what is in its lists."""
    opened: list[_Open] = []
    for token in _VALUE_TOKEN.finditer(text, at):
        mark, here = token[0], line
        line += mark.count("\n")
        if mark == "\n" and not opened:
            return token.end()
        if mark.isspace() or mark[0] == "#":
            continue
        if mark in "]}":
            opened.pop()
            continue
        inner = opened[-1].inner() if opened else path
        if opened and mark == ",":
            opened[-1].entry += 1
            opened[-1].awaited = True
        elif opened and opened[-1].awaited:
            opened[-1].awaited = False
            if inner is not None:
                found.setdefault(inner, here)
        if mark in "[{":
            opened.append(_Open(inner if mark == "[" else None))
    return len(text)
