"""Counts sixteenths of a bit in HCLK cycles, also while the length of a bit changes."""

from __future__ import annotations

from fractions import Fraction

__all__ = ["BitClock"]


class BitClock:
    """Says at which cycle something on a serial line happens that begins at a cycle and is counted in bits.

    Attributes:
        bit_cycles: present length of a bit; a fraction where the clock of the bits does not come from HCLK.
    """

    __slots__ = ("_origin", "_origin_cycle", "bit_cycles")

    def __init__(self) -> None:
        self.bit_cycles: int | Fraction = 16
        self._origin: int | Fraction = 0
        self._origin_cycle = 0

    def start(self, cycle: int, bit_cycles: int | Fraction) -> None:
        """Begin to count at `cycle`."""
        self._origin = 0
        self._origin_cycle = cycle
        self.bit_cycles = bit_cycles

    def change(self, cycle: int, bit_cycles: int | Fraction) -> None:
        """Let a bit take `bit_cycles` from `cycle` on."""
        self._origin += Fraction(16 * (cycle - self._origin_cycle), self.bit_cycles)
        self._origin_cycle = cycle
        self.bit_cycles = bit_cycles

    def cycle(self, sixteenths: int) -> int:
        """Return the first cycle at or after that many sixteenths of a bit."""
        return self._origin_cycle - (self._origin - sixteenths) * self.bit_cycles // 16

    def passed(self, cycle: int) -> Fraction:
        """Return how many sixteenths of a bit have passed at `cycle`, after the last change."""
        return self._origin + Fraction(16 * (cycle - self._origin_cycle), self.bit_cycles)
