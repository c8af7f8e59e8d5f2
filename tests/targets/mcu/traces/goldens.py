"""The golden traces: committed text, abridged where it would be long, so that a difference can still be found.

Of a long trace its beginning and its end are kept as they are; in between, blocks of lines stand as one line each, with
the cycles from which to which they reach and a hash. `python -m tests.targets.mcu.traces --print NAME` has all lines.
"""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Iterable
from pathlib import Path

__all__ = ["abridged", "difference", "golden_path", "lines_of"]

_EXPECTED = Path(__file__).parent / "expected"
_WHOLE, _FIRST, _BLOCK, _LAST = 400, 200, 50, 50


def golden_path(name: str) -> Path:
    """Return where the golden trace of a scenario lies."""
    return _EXPECTED / f"{name}.txt"


def lines_of(name: str) -> list[str]:
    """Return the lines of a golden trace; none if there is no such file."""
    path = golden_path(name)
    return path.read_text(encoding="utf-8").splitlines() if path.is_file() else []


def abridged(header: list[str], lines: list[str]) -> list[str]:
    """Return what is committed of a trace."""
    if len(lines) <= _WHOLE:
        return [*header, *lines]
    middle = lines[_FIRST:-_LAST]
    blocks = (middle[at : at + _BLOCK] for at in range(0, len(middle), _BLOCK))
    return [*header, *lines[:_FIRST], *map(_block, blocks), *lines[-_LAST:]]


def _block(lines: list[str]) -> str:
    first, last = (line.partition(" ")[0] for line in (lines[0], lines[-1]))
    digest = hashlib.sha256("\n".join(lines).encode()).hexdigest()[:16]
    return f"... {len(lines)} lines, cycles {first} to {last}, sha256 {digest}"


def difference(expected: Iterable[str], found: Iterable[str]) -> str:
    """Return the first lines that differ, in words; empty if none do."""
    for number, (old, new) in enumerate(itertools.zip_longest(expected, found, fillvalue="(nothing)"), 1):
        if old != new:
            return f"line {number}: expected {old!r}, found {new!r}"
    return ""
