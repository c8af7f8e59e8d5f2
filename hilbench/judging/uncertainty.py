"""Where the uncertainty of a figure comes from: of how late benches were, or of something else.

A fail on a late bench stands if what the bench was late by is in the figure's uncertainty; an uncertainty of another
origin, such as what a sensor resolves, says nothing of that (`hilbench.judging.doubt`). So what a bench is late by is a
float of its own kind, which it hands down to all that is made of it: a speed times it is an uncertain way.
"""

from __future__ import annotations

__all__ = ["OfTimes"]


class OfTimes(float):
    """An uncertainty that has in it what the benches were late by; so has what it is added to, or a multiple of it.

    What `round`, `math` and numpy make of it is a plain float.
    """

    __slots__ = ()

    def __add__(self, other: float, /) -> OfTimes:
        """Return the sum, of times too."""
        return _of_times(float.__add__(self, other))

    def __mul__(self, other: float, /) -> OfTimes:
        """Return the product, of times too."""
        return _of_times(float.__mul__(self, other))

    def __truediv__(self, other: float, /) -> OfTimes:
        """Return the quotient, of times too."""
        return _of_times(float.__truediv__(self, other))

    def __sub__(self, other: float, /) -> OfTimes:
        """Return the difference, of times too."""
        return _of_times(float.__sub__(self, other))

    def __rsub__(self, other: float, /) -> OfTimes:
        """Return the difference, of times too."""
        return _of_times(float.__rsub__(self, other))

    def __neg__(self) -> OfTimes:
        """Return it below zero, of times too."""
        return OfTimes(float.__neg__(self))

    def __abs__(self) -> OfTimes:
        """Return its magnitude, of times too."""
        return OfTimes(float.__abs__(self))

    __radd__ = __add__
    __rmul__ = __mul__


def _of_times(value: float) -> OfTimes:
    return value if value is NotImplemented else OfTimes(value)
