"""From a voltage to what stands in a data register of a 16-bit ADC: resolution, offset, oversampling (RM0433 25.4).

Choices where the manual is silent:

* The first step of the ideal converter is half an LSB above 0 V.
* An offset is for a result of 16 bits, and for a smaller resolution its lowest bits are dropped; with oversampling it
  is subtracted as it is.
"""

from __future__ import annotations

from fractions import Fraction

from targets.mcu.stm32.adc_format import code

__all__ = ["BITS", "SAMPLING_CLOCKS", "code", "conversion_clocks", "outside", "result", "with_offset"]

BITS = (16, 14, 12, 10, 16, 14, 12, 8)
"""Resolution in bits by CFGR.RES, on revision V; 4 is reserved. 1 and 2 are those of revision Y."""
SAMPLING_CLOCKS = tuple(Fraction(twice, 2) for twice in (3, 5, 17, 33, 65, 129, 775, 1621))
"""By SMP: 1.5, 2.5, 8.5, 16.5, 32.5, 64.5, 387.5 and 810.5 clocks of the ADC."""


def conversion_clocks(bits: int) -> Fraction:
    """Return the clocks from the end of the sampling time to the result: 8.5 for 16 bits, one less for two bits."""
    return Fraction(bits + 1, 2)


def with_offset(value: int, offset: int, bits: int, *, saturate: bool) -> int:
    """Return a result less its offset, which may be negative.

    Args:
        value: the result.
        offset: OFFSETy, for 16 bits.
        bits: of the result; more than 16 if it is a sum of several.
        saturate: SSATE: keep it within the signed numbers of so many bits.
    """
    less = value - (offset >> max(16 - bits, 0))
    top = 1 << bits - 1
    return max(-top, min(top - 1, less)) if saturate else less


def result(value: int, left_shift: int) -> int:
    """Return a word for DR, whose sign is extended."""
    return (value << left_shift) & 0xFFFF_FFFF


def outside(value: int, bits: int, low: int, high: int) -> bool:
    """Say whether an analog watchdog barks; the thresholds are for 16 bits, or for the sum of several results."""
    full = value << max(16 - bits, 0)
    return full < low or full > high
