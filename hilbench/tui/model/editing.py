"""A message with other values: its fields as somebody types them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from enum import Enum
from typing import Any

__all__ = ["can_be_edited", "edited", "text_in", "values_of"]

_KINDS: Mapping[type, str] = {bool: "yes or no", int: "whole number", float: "number", bytes: "bytes in hex"}


def values_of(message: Any) -> dict[str, object]:
    """Return the fields of a message, a dataclass or a named tuple, by their names."""
    if dataclasses.is_dataclass(message):
        return {one.name: getattr(message, one.name) for one in dataclasses.fields(message)}
    return dict(message._asdict()) if hasattr(message, "_asdict") else {}


def edited(message: Any, texts: Mapping[str, str]) -> object:
    """Return a message with other values.

    Args:
        message: a dataclass or a named tuple.
        texts: the values of some fields, in words.

    Raises:
        ValueError: a text is no such value, or the message does not take it.
    """
    values = values_of(message)
    changes = {name: _value(name, values[name], text) for name, text in texts.items() if text != text_in(values[name])}
    try:  # a plug-in's class may refuse what somebody has typed, in its own way
        if dataclasses.is_dataclass(message) and not isinstance(message, type):
            return dataclasses.replace(message, **changes)
        return message._replace(**changes) if changes else message
    except Exception as error:
        raise ValueError(f"{error}") from error


def can_be_edited(value: object) -> bool:
    """Return whether a value can be typed."""
    return value is None or isinstance(value, bool | int | float | str | bytes | Enum)


def text_in(value: object) -> str:
    """Return a value as it is typed."""
    if isinstance(value, Enum):
        return value.name or str(value.value)
    if isinstance(value, bytes):
        return value.hex(" ").upper()
    return "" if value is None else str(value)


def _value(name: str, before: object, text: str) -> object:
    try:
        match before:
            case bool():
                return {"true": True, "1": True, "yes": True, "false": False, "0": False, "no": False}[text.lower()]
            case Enum():
                return type(before)(int(text, 0)) if text[:1].isdigit() else type(before)[text]
            case int():
                return int(text, 0)
            case float():
                return float(text)
            case bytes():
                return bytes.fromhex(text)
            case None:
                return int(text, 0) if text.lstrip("+-")[:1].isdigit() else text.encode()
    except (ValueError, KeyError):
        raise ValueError(f"{name}: '{text}' is no {_KINDS.get(type(before), 'value of it')}") from None
    return text
