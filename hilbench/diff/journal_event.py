"""Whether the events of a journal have what a comparison reads of them.

A journal is a file like any other: cut, edited or written by another program. What is wrong is said with its line.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from hilbench.errors import UnavailableError
from hilbench.journal import Recording

__all__ = ["BYTES", "check_events"]

BYTES = frozenset({"tx", "rx", "console"})
"""Kinds of events that carry bytes of a line."""

Event = Mapping[str, Any]
Rule = tuple[str, Callable[[object], str]]
"""A field, and what says what its value is instead of what it should be: nothing if all is well."""


def check_events(path: Path, recording: Recording) -> None:
    """Make sure that the header and the events of a journal can be compared.

    Raises:
        UnavailableError: a field is missing, or has no such value; the line is named.
    """
    if not isinstance(recording.header.get("images", {}), dict):
        raise UnavailableError("'images' is no table of boards", where=f"{path}:1")
    for number, event in enumerate(recording.events, 2):  # an event is a line, and the first line is the header
        wrong = next(filter(None, _found(event)), None)
        if wrong is not None:
            raise UnavailableError(wrong, where=f"{path}:{number}")


def _found(event: Event) -> Iterator[str]:
    """Say of each field what is wrong with it, nothing if all is well."""
    yield from (_wrong(event, name, check) for name, check in _ALL)
    kind = event["kind"]
    yield from (_wrong(event, name, check) for name, check in _NEEDED.get(kind, ()))
    if kind == "pwm" and "period_ns" in event:
        yield from (_wrong(event, name, _whole) for name in ("period_ns", "high_ns"))
    if kind in BYTES:
        yield from (_wrong(event, name, check) for name, check in _OF_BYTES if name in event)
    value = event.get("value")
    if kind == "event" and isinstance(value, dict) and "at_ns" in value:
        yield _wrong(value, "at_ns", _whole)


def _wrong(fields: Event, name: str, check: Callable[[object], str]) -> str:
    if name not in fields:
        return f"'{name}' is missing"
    wrong = check(fields[name])
    return wrong and f"'{name}' is {wrong}"


def _whole(value: object) -> str:
    return "" if type(value) is int else "no whole number"


def _text(value: object) -> str:
    return "" if isinstance(value, str) else "no text"


def _level(value: object) -> str:
    return "" if value is None or isinstance(value, bool) else "no level: true, false or null"


_ALL: tuple[Rule, ...] = (("kind", _text), ("ns", _whole), ("source", _text))
_OF_BYTES: tuple[Rule, ...] = (("data", _text), ("from_ns", _whole))
_NEEDED: dict[str, tuple[Rule, ...]] = {
    "pin": (("level", _level),),
    "frames": (("pin", _text),),
    "pwm": (("edges", _whole), ("in_ns", _whole)),
    "case": (("case", _text),),
}
