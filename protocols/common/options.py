"""What options of every protocol are looked at for."""

from __future__ import annotations

from collections.abc import Iterable


def check_positive(error: type[Exception], options: object, names: Iterable[str]) -> None:
    """Raise the error for the first of these figures that is there and not above 0."""
    for name in names:
        value = getattr(options, name)
        if value is not None and not value > 0:
            raise error(f"{name} is {value}, not above 0")
