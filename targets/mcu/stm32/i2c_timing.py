"""How long the conditions and bits of an I2C master take (RM0410 sections 33.4.5 and 33.4.9, "master initialization").

The manual gives t_SCL = t_SYNC1 + t_SYNC2 + ((SCLH + 1) + (SCLL + 1)) x (PRESC + 1) x t_I2CCLK. The two t_SYNC are what
passes until an edge of SCL that the master made has come back to it through its filters.

Choices where the manual gives a range or nothing:

* A t_SYNC is two clocks of synchronisation (of "2 to 3"), DNF clocks of the digital filter, and 100 ns of the analog
  filter (50 to 260 ns in the manual) where that is on, in whole clocks, rounded up. Edges take no time.
* SCL stays low for the longer one of t_SCLL and of t_SDADEL and t_SCLDEL together, in both directions.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

__all__ = ["Timing"]

_ANALOG_FILTER_S = Fraction(100, 1_000_000_000)
_SYNCHRONISATION = 2
_ANFOFF = 1 << 12


@dataclass(frozen=True, slots=True)
class Timing:
    """Durations in clocks of the kernel.

    Attributes:
        cycles: HCLK cycles of one such clock; an int wherever it is a whole number.
        low: SCL low, from the edge until it is released.
        high: SCL high, from the edge until it is driven low.
        hold: from START until SCL is driven low, t_HD;STA, of SCLH.
        restart: from SCL low to a repeated START: t_LOW and t_SU;STA, of SCLL.
        free: from a STOP to the next START, t_BUF, of SCLL.
    """

    cycles: Fraction | int
    low: int
    high: int
    hold: int
    restart: int
    free: int

    @classmethod
    def of(cls, timingr: int, cr1: int, kernel_hz: Fraction, hclk_hz: Fraction) -> Timing:
        """Return the durations that TIMINGR and the filters in CR1 give; the kernel clock runs."""
        cycles = hclk_hz / kernel_hz
        sync = _SYNCHRONISATION + (cr1 >> 8 & 0xF) + (0 if cr1 & _ANFOFF else math.ceil(_ANALOG_FILTER_S * kernel_hz))
        tick = (timingr >> 28) + 1
        scll, sclh = (timingr & 0xFF) + 1, (timingr >> 8 & 0xFF) + 1
        data = (timingr >> 16 & 0xF) * tick + 1 + ((timingr >> 20 & 0xF) + 1) * tick
        low = sync + max(scll * tick, data)
        return cls(
            cycles=cycles.numerator if cycles.denominator == 1 else cycles,
            low=low,
            high=sync + sclh * tick,
            hold=sclh * tick,
            restart=low + sync + scll * tick,
            free=scll * tick,
        )

    @property
    def bit(self) -> int:
        """One clock of SCL, or from SCL low to a STOP: t_LOW and t_SU;STO."""
        return self.low + self.high
