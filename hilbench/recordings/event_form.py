"""Whether an event of a recording has what its readers take for granted.

A recording is a file like any other: cut, edited, damaged or written by another program. What is wrong is said.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from hilbench.recordings.layout import BYTE_KINDS, Event

__all__ = ["wrong_with"]

_END_NS = 2**62
"""Times are before it: some 146 years, and room for several cases in formats whose times have 64 bits."""

Rule = tuple[str, Callable[[object], str]]
"""A field, and what says what its value is instead of what it should be: nothing if all is well."""


def wrong_with(event: Event) -> str:
    """Say what is wrong with an event, without a full stop; nothing if all is well."""
    return next(filter(None, _found(event)), "")


def _found(event: Event) -> Iterator[str]:
    """Say of each field what is wrong with it, nothing if all is well."""
    yield from (_wrong(event, name, check) for name, check in _ALL)
    kind = event["kind"]
    yield from (_wrong(event, name, check) for name, check in _NEEDED.get(kind, ()))
    if kind == "pwm" and "period_ns" in event:
        yield from (_wrong(event, name, _whole) for name in ("period_ns", "high_ns"))
    yield from (_wrong(event, name, check) for name, check in _MAY_HAVE.get(kind, ()) if name in event)
    value = event.get("value")
    if kind == "event" and isinstance(value, dict) and "at_ns" in value:
        yield _wrong(value, "at_ns", _time)


def _wrong(fields: Event, name: str, check: Callable[[object], str]) -> str:
    if name not in fields:
        return f"'{name}' is missing"
    wrong = check(fields[name])
    return wrong and f"'{name}' is {wrong}"


def _whole(value: object) -> str:
    return "" if type(value) is int else "no whole number"


def _time(value: object) -> str:
    return _whole(value) or ("" if isinstance(value, int) and 0 <= value < _END_NS else "no time of a bench")


def _text(value: object) -> str:
    return "" if isinstance(value, str) else "no text"


def _hex(value: object) -> str:
    if not isinstance(value, str):
        return _text(value)
    try:
        bytes.fromhex(value)
    except ValueError:
        return "no bytes in hex"
    return ""


def _level(value: object) -> str:
    return "" if value is None or isinstance(value, bool) else "no level: true, false or null"


def _share(value: object) -> str:
    return "" if isinstance(value, float | int) and 0 <= value <= 1 else "no part of 1"


def _points(value: object) -> str:
    if not isinstance(value, list):
        return "no list"
    times = all(isinstance(point, list) and len(point) == 3 and not any(map(_time, point)) for point in value)
    return "" if times else "no list of three times each"


_ALL: tuple[Rule, ...] = (("kind", _text), ("ns", _time), ("source", _text))
_MAY_HAVE: dict[str, tuple[Rule, ...]] = {
    **dict.fromkeys(BYTE_KINDS, (("data", _hex), ("from_ns", _time))),
    "console": (("data", _text), ("from_ns", _time)),
    "pwm": (("duty", _share),),
}
_NEEDED: dict[str, tuple[Rule, ...]] = {
    "pin": (("level", _level),),
    "frames": (("pin", _text),),
    "pwm": (("edges", _whole), ("in_ns", _whole)),
    "case": (("case", _text),),
    "margins": (("timer", _text), ("points", _points)),
}
