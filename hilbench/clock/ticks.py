"""Bench time in numbers: nanoseconds, and the whole ticks of one clock."""

from __future__ import annotations

from fractions import Fraction

NS_PER_S = 1_000_000_000
NS_PER_MS = 1_000_000
NS_PER_US = 1_000


class ClockDomain:
    """Whole ticks of one clock and the bench time at which they fall.

    Tick k falls at floor(k / hz) nanoseconds after the domain's epoch. The time is computed from k every time, so no
    rounding error accumulates. `ticks` is the exact inverse: for clocks of up to 1 GHz `ticks(ns(k)) == k`.

    Args:
        hz: Rate in ticks per second, greater than zero; a Fraction for a rate such as 72 MHz / 7500.
    """

    __slots__ = ("_denominator", "_numerator", "hz")

    def __init__(self, hz: int | Fraction) -> None:
        if hz <= 0:
            raise ValueError(f"a clock needs a rate above zero, not {hz}")
        self.hz = Fraction(hz)
        # ns(k) = k * _numerator // _denominator
        self._numerator = NS_PER_S * self.hz.denominator
        self._denominator = self.hz.numerator

    def ns(self, ticks: int) -> int:
        """Return the nanoseconds from the epoch to tick number `ticks`, rounded down."""
        return ticks * self._numerator // self._denominator

    def ticks(self, ns: int) -> int:
        """Return the number of the last tick that has fallen by `ns` after the epoch."""
        return ((ns + 1) * self._denominator - 1) // self._numerator
