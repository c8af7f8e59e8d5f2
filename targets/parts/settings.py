"""Settings of parts: frozen dataclasses whose fields know their unit and where their value comes from.

A source names a public document or program. "assumed" marks a physical value nobody published, "choice" a decision of
ours.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from typing import Any, Literal, get_args, get_origin, get_type_hints

__all__ = ["Described", "check_settings", "describe", "setting"]

_hints: Callable[[type], dict[str, Any]] = functools.cache(get_type_hints)


@dataclass(frozen=True, slots=True, kw_only=True)
class Described:
    """One setting: its name, value, unit (empty for none) and source."""

    name: str
    value: object
    unit: str
    source: str


def setting(default: Any, unit: str, source: str, *, least: float | None = None, greatest: float | None = None) -> Any:
    """A field of a class of settings.

    Args:
        default: the default value.
        unit: of the value; empty for none.
        source: where the value, or the choice of values, comes from.
        least: the smallest number that makes sense; None for no bound.
        greatest: the greatest.
    """
    return field(default=default, metadata={"unit": unit, "source": source, "least": least, "greatest": greatest})


def describe(settings: Any) -> tuple[Described, ...]:
    """List every setting with unit and source, in the order of the class."""
    return tuple(
        Described(name=f.name, value=getattr(settings, f.name), unit=f.metadata["unit"], source=f.metadata["source"])
        for f in fields(settings)
    )


def check_settings(settings: Any) -> None:
    """Check every value against its type and bounds; for the `__post_init__` of a class of settings.

    Raises:
        ValueError: a value is none of its choices, not of its type, not finite or out of bounds. The text begins with
            the name of the setting.
    """
    hints = _hints(type(settings))
    for item in fields(settings):
        value = getattr(settings, item.name)
        _check_type(item.name, value, hints[item.name])
        if isinstance(value, int | float) and not isinstance(value, bool):
            _check_number(item.name, value, item.metadata["least"], item.metadata["greatest"])


def _check_type(name: str, value: object, hint: Any) -> None:
    if get_origin(hint) is Literal:
        if value not in get_args(hint):
            raise ValueError(f"{name} must be one of {', '.join(map(str, get_args(hint)))}, not {value!r}")
        return
    kinds = get_args(hint) or (hint,)
    fits = any(_is_of(value, kind) for kind in kinds)
    if not fits:
        wanted = " or ".join("nothing" if kind is type(None) else kind.__name__ for kind in kinds)
        raise ValueError(f"{name} must be {wanted}, not {value!r}")


def _is_of(value: object, kind: type) -> bool:
    if isinstance(value, bool):
        return kind is bool
    return isinstance(value, int | float) if kind is float else isinstance(value, kind)


def _check_number(name: str, number: float, least: float | None, greatest: float | None) -> None:
    if not math.isfinite(number):
        raise ValueError(f"{name} must be finite, not {number!r}")
    if least is not None and number < least:
        raise ValueError(f"{name} must be at least {least}, not {number!r}")
    if greatest is not None and number > greatest:
        raise ValueError(f"{name} must be at most {greatest}, not {number!r}")
