"""The part of the clock tree from SYSCLK to the buses, which the families have in common, as arithmetic.

SYSCLK is divided for HCLK, and HCLK for each of the two peripheral buses (RM0008 section 7.2, RM0410 section 5.2).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Generic, TypeVar

__all__ = ["AHB_DIVIDERS", "APB_DIVIDERS", "BasicClockTree", "BusRates"]

AHB_DIVIDERS = (1, 1, 1, 1, 1, 1, 1, 1, 2, 4, 8, 16, 64, 128, 256, 512)
"""By the value of CFGR.HPRE."""
APB_DIVIDERS = (1, 1, 1, 1, 2, 4, 8, 16)
"""By the values of CFGR.PPRE1 and PPRE2."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BusRates:
    """Rates in hertz, and the dividers from HCLK to the two peripheral buses.

    Attributes:
        sysclk: before the AHB prescaler.
        hclk: CPU, memory, DMA.
        apb1: HCLK cycles per tick of PCLK1.
        apb2: HCLK cycles per tick of PCLK2.
    """

    sysclk: Fraction
    hclk: Fraction
    apb1: int
    apb2: int

    @property
    def pclk1(self) -> Fraction:
        """Rate of PCLK1."""
        return self.hclk / self.apb1

    @property
    def pclk2(self) -> Fraction:
        """Rate of PCLK2."""
        return self.hclk / self.apb2

    def dividers(self) -> Mapping[str, int]:
        """Return HCLK cycles per tick of each bus by its name."""
        return {"AHB": 1, "APB1": self.apb1, "APB2": self.apb2}

    def timer(self, divider: int) -> int:
        """Return HCLK cycles per tick of the timers on a bus with that divider.

        They run at twice the bus clock unless its divider is 1 (RM0008 section 7.2, figure 8; RM0410 section 5.2.10).
        """
        return max(divider // 2, 1)


AnyRates = TypeVar("AnyRates", bound=BusRates)


class BasicClockTree(Generic[AnyRates]):
    """The present rates, as the peripherals ask for them; RCC sets them.

    Args:
        rates: those after a reset.

    Attributes:
        rates: the present rates.
        stopped: Stop mode: every derived clock stands still.
    """

    def __init__(self, rates: AnyRates) -> None:
        self.rates = rates
        self.stopped = False
        self._pclk: dict[str, int] = {}
        self._timer: dict[str, int] = {}
        self.set(rates, stopped=False)

    def set(self, rates: AnyRates, *, stopped: bool) -> None:
        """Take over new rates."""
        self.rates = rates
        self.stopped = stopped
        for bus, divider in rates.dividers().items():
            self._pclk[bus] = 0 if stopped else divider
            self._timer[bus] = 0 if stopped else rates.timer(divider)

    def pclk(self, bus: str) -> int:
        """Return HCLK cycles per tick of the bus clock; 0 in Stop mode."""
        return self._pclk[bus]

    def timer(self, bus: str) -> int:
        """Return HCLK cycles per tick of the timers' clock on that bus; 0 in Stop mode."""
        return self._timer[bus]
