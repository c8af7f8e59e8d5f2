"""Items as lines: for people, or as JSON, one object a line."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from enum import Enum
from typing import Any

from hilbench.clock import NS_PER_S
from protocols.common.item_words import said
from protocols.common.items import Item, Kind

__all__ = ["json_line", "plain", "text_line"]


def text_line(item: Item, offset: int, stream: str, ns: int | None) -> str:
    """Return an item as a line for people: offset, time and stream where there are any, what it is."""
    columns = [f"{offset:8d}"]
    if ns is not None:
        columns.append(f"{ns / NS_PER_S:12.6f} s")
    if stream:
        columns.append(f"{stream:<12}")
    columns.append(said(item))
    return "  ".join(columns)


def json_line(item: Item, offset: int, stream: str, ns: int | None) -> str:
    """Return an item as a JSON object; a number that JSON does not have is a text: ``"nan"``, ``"inf"``."""
    about: dict[str, Any] = {"offset": offset}
    if ns is not None:
        about["ns"] = ns
    if stream:
        about["stream"] = stream
    about |= {"kind": item.kind.value, "name": item.name}
    if item.kind is Kind.FRAME:
        about["fields"] = {name: plain(value) for name, value in item.fields.items()}
    about["raw"] = item.raw.hex()
    return json.dumps(about)


def plain(value: object) -> object:
    """Return the value of a field as what JSON has."""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, bytes):
        return value.hex()
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, Mapping):
        return {str(name): plain(one) for name, one in value.items()}
    if hasattr(value, "__dataclass_fields__"):
        return {name: plain(getattr(value, name)) for name in value.__dataclass_fields__}
    if isinstance(value, Iterable) and not isinstance(value, str):
        return [plain(one) for one in value]
    return value
