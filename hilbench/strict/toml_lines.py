"""Finds the line of a key in TOML text; `tomllib` reads values but does not say where they stood.

Reads just enough of TOML for that: headers, keys, and where a value ends. It is only asked about text that `tomllib`
has accepted, so it need not recognise errors.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

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
        path: keys, and indices from 0 in arrays of tables.
    """
    lines = _lines(text)
    for length in range(len(path), 0, -1):
        line = lines.get(tuple(path[:length]))
        if line is not None:
            return line
    return None


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
            at = _after_value(text, at + key.end())
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


def _after_value(text: str, at: int) -> int:
    depth = 0
    for token in _VALUE_TOKEN.finditer(text, at):
        if token[0] in "[{":
            depth += 1
        elif token[0] in "]}":
            depth -= 1
        elif token[0] == "\n" and depth == 0:
            return token.end()
    return len(text)
