"""Sequence numbers of 16 bits that begin anew at 0, compared as in RFC 1982 (OMG DDS-XRCE 1.0, 8.3.2.3)."""

from __future__ import annotations

__all__ = ["BEFORE_FIRST", "after", "ahead", "is_newer"]

BEFORE_FIRST = 0xFFFF
"""The number before the first one, which is 0."""

_HALF = 0x8000


def after(number: int, steps: int = 1) -> int:
    """The number so many steps later."""
    return (number + steps) & 0xFFFF


def ahead(number: int, other: int) -> int:
    """How many steps lead from the other number to this one, 0..65535."""
    return (number - other) & 0xFFFF


def is_newer(number: int, other: int) -> bool:
    """The number is a later one; of two that are 32768 apart neither is."""
    return 0 < ahead(number, other) < _HALF
