"""From a voltage to what stands in a data register of an ADC (RM0410 sections 15.3.12 and 15.7, data alignment)."""

from __future__ import annotations

__all__ = ["BITS", "aligned", "code", "injected", "outside"]

BITS = (12, 10, 8, 6)
"""Resolution in bits, by CR1.RES."""


def code(volts: float, reference_volts: float, bits: int) -> int:
    """Return the code of an ideal converter, whose first step is half an LSB above 0 V (choice)."""
    top = (1 << bits) - 1
    return max(0, min(top, int(volts / reference_volts * (top + 1) + 0.5)))


def aligned(value: int, bits: int, *, left: bool) -> int:
    """Return a code as it stands in DR: left alignment is to 16 bits, but for 6 bits, which are aligned to a byte."""
    if not left:
        return value
    return value << (2 if bits == 6 else 16 - bits)


def injected(value: int, offset: int, bits: int, *, left: bool) -> int:
    """Return a code less its offset as it stands in JDR: sign-extended, one bit further right when aligned left."""
    shift = 0 if not left else 1 if bits == 6 else 15 - bits
    return (value - offset << shift) & 0xFFFF


def outside(value: int, bits: int, low: int, high: int) -> bool:
    """Say whether the analog watchdog barks: the thresholds are those of a code of 12 bits, whatever the resolution."""
    full = value << 12 - bits
    return full < low or full > high
