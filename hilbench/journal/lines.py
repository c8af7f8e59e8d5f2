"""Events as lines of JSON."""

from __future__ import annotations

import dataclasses
import enum
from collections.abc import Iterable, Mapping
from typing import Any

import msgspec

from hilbench.files.names import escaped_all

__all__ = ["decoded", "encoded", "plain"]

_encoder = msgspec.json.Encoder()


def plain(value: object) -> Any:
    """Return a value as what JSON has: bytes as hex, members by name, dataclasses as objects."""
    if value is None or type(value) in (int, str, bool, float):
        return value
    if isinstance(value, enum.Enum):
        return value.name
    if isinstance(value, bytes | bytearray | memoryview):
        return value.hex()
    if isinstance(value, Mapping):
        return {str(plain(key)): plain(item) for key, item in value.items()}
    if isinstance(value, set | frozenset):
        return sorted((plain(item) for item in value), key=str)
    if isinstance(value, Iterable) and not isinstance(value, str):
        return [plain(item) for item in value]
    if dataclasses.is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    return _plain_scalar(value)


def _plain_scalar(value: object) -> int | float | str:
    """Return subclasses of the built-in scalars, such as numpy's float64, as these; anything else as its text."""
    if isinstance(value, int):
        return int(value)
    return float(value) if isinstance(value, float) else str(value)


def encoded(value: object, encoder: msgspec.json.Encoder = _encoder) -> bytes:
    """Return a line of JSON; names that are not UTF-8 are rare, and cost only those who have them."""
    try:
        return encoder.encode(value) + b"\n"
    except UnicodeEncodeError:
        return encoder.encode(escaped_all(value)) + b"\n"


def decoded(line: bytes) -> dict[str, Any] | None:
    """Return what a line says; None of one that is damaged, and be it with brackets without end."""
    try:
        return msgspec.json.decode(line, type=dict[str, Any])
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return None
