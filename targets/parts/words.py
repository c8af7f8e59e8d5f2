"""Numbers on three wires: motor codes (two's complement) and sectors of encoders (bachelor-thesis, Fig. 22)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

__all__ = ["LSB_FIRST", "MSB_FIRST", "BitOrder", "bits_of", "signed", "word_of"]

BitOrder = Literal["lsb-first", "msb-first"]
"""Which bit the first of three wires (s1, comm1) carries; the third carries the opposite one."""

LSB_FIRST: BitOrder = "lsb-first"
MSB_FIRST: BitOrder = "msb-first"


def signed(word: int) -> int:
    """The code -4..3 of a word 0..7: two's complement of three bits."""
    return word - 8 if word & 4 else word


def bits_of(word: int, order: BitOrder) -> tuple[bool, bool, bool]:
    """The levels of the first, second and third wire for a word; only its low three bits count."""
    low_first = bool(word & 1), bool(word & 2), bool(word & 4)
    return low_first if order == LSB_FIRST else (low_first[2], low_first[1], low_first[0])


def word_of(bits: Iterable[bool], order: BitOrder) -> int:
    """The word 0..7 of the levels of the first, second and third wire."""
    first, second, third = bits
    if order == MSB_FIRST:
        first, third = third, first
    return first | second << 1 | third << 2
