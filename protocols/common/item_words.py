"""Items in words, for people."""

from __future__ import annotations

from enum import Enum

from protocols.common.items import Item, Kind

__all__ = ["said", "value_text"]

_SHOWN_BYTES = 24


def said(item: Item) -> str:
    """Return what an item says, in words; the bytes of it if it says nothing."""
    if item.kind is Kind.FRAME:
        fields = [f"{name}={value_text(value)}" for name, value in item.fields.items() if value is not None]
        return " ".join([item.name, *fields])
    more = f" ... ({len(item.raw)} bytes)" if len(item.raw) > _SHOWN_BYTES else ""
    return f"!! {item.name}: {item.raw[:_SHOWN_BYTES].hex(' ').upper()}{more}"


def value_text(value: object) -> str:
    """Return the value of a field in words."""
    if isinstance(value, float):
        return f"{value:.7g}"
    if isinstance(value, bytes):
        return value.hex(" ").upper() or "-"
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, tuple | list):
        return "[" + " ".join(map(value_text, value)) + "]"
    return str(value)
