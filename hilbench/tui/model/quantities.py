"""What fields of messages are, for people: their names, their units, and figures in few letters."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from enum import Enum

from hilbench.plugins.protocol import Quantity
from protocols.common.item_words import value_text

__all__ = ["numbers_of", "quantity_of", "text_of"]

_UNITS = (
    ("_mm_s", "mm/s", 1.0), ("_m_s2", "m/s²", 1.0), ("_m_s", "m/s", 1.0), ("_deg_s", "°/s", 1.0),
    ("_rad_s", "rad/s", 1.0), ("_cdeg", "°", 0.01), ("_deg", "°", 1.0), ("_rad", "rad", 1.0), ("_kmh", "km/h", 1.0),
    ("_dv", "V", 0.1), ("_rpm", "rpm", 1.0), ("_v", "V", 1.0), ("_a", "A", 1.0), ("_c", "°C", 1.0),
    ("_mgauss", "mG", 1.0), ("_mm", "mm", 1.0), ("_m", "m", 1.0), ("_percent", "%", 1.0),
)  # fmt: skip
"""How fields with a unit end their names; what the value is multiplied by to be in it."""
_DIGITS = 5
_BARE = Quantity("")


def quantity_of(name: str, known: Mapping[str, Quantity]) -> Quantity:
    """Return what a field is: as its protocol says, else by the end of its name."""
    if name in known:
        return known[name]
    for end, unit, scale in _UNITS:
        if name.endswith(end):
            return Quantity(name[: -len(end)].replace("_", " "), unit, scale)
    return Quantity(name.replace("_", " "))


def numbers_of(value: object, quantity: Quantity) -> list[float]:
    """Return the numbers of a field in its unit: one, or those of a list; none where something else stands there."""
    parts = value if isinstance(value, list | tuple) else (value,)
    numbers = [_in_unit(part, quantity) for part in parts if isinstance(part, int | float)]
    return numbers if len(numbers) == len(parts) else []


def text_of(value: object, quantity: Quantity) -> str:
    """Return a value in its unit, in words; a record within it as ``3:241``, its last number in the unit."""
    match value:
        case bool():
            return "yes" if value else "no"
        case Enum():
            return value.name or str(value.value)  # a set of flags may have none
        case int() if quantity.scale == 1:
            return str(round(_in_unit(value, quantity)))
        case int() | float():
            return _figure(_in_unit(value, quantity))
        case list() | tuple() if not hasattr(value, "_fields"):
            return " ".join(text_of(part, quantity) for part in value) or "-"
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        *first, last = (getattr(value, one.name) for one in dataclasses.fields(value))
        return ":".join([*(text_of(part, _BARE) for part in first), text_of(last, quantity)])
    return value_text(value)


def _in_unit(value: float, quantity: Quantity) -> float:
    wraps_at = quantity.wraps_at
    if wraps_at and isinstance(value, int):
        value = (value + wraps_at // 2) % wraps_at - wraps_at // 2
    return value * quantity.scale


def _figure(value: float) -> str:
    shown = f"{value:.{_DIGITS}g}"
    return "0" if shown == "-0" else shown
