"""What options of every protocol are looked at for."""

from __future__ import annotations

import math
from collections.abc import Iterable


def check_positive(error: type[Exception], options: object, names: Iterable[str]) -> None:
    """Raise the error for the first of these figures that is there and not above 0, or not finite."""
    for name in names:
        value = getattr(options, name)
        if value is not None and not 0 < value < math.inf:
            raise error(f"{name} is {value}, not {'finite' if value == math.inf else 'above 0'}")
