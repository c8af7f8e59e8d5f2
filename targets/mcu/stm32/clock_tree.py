"""The part of the clock tree from SYSCLK to the buses, which the families have in common, as arithmetic.

SYSCLK is divided for HCLK, and HCLK for each of the two peripheral buses (RM0008 section 7.2, RM0410 section 5.2).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Generic, TypeVar

__all__ = [
    "AHB_DIVIDERS",
    "APB_DIVIDERS",
    "BasicClockTree",
    "BusRates",
    "KernelChoice",
    "KernelClockTree",
    "KernelRates",
]

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


@dataclass(frozen=True, slots=True, kw_only=True)
class KernelRates(BusRates):
    """Rates where peripherals have a choice of clocks (RM0410 section 5.2, RM0433 section 8.5); see `BusRates`.

    Attributes:
        all_timers: TIMPRE: the timers run at the rate of AHB as long as the bus is divided by 4 at most, else at 4
            times its rate.
        kernels: rate of the clock that each peripheral with a choice runs on; 0 for none.
        in_stop: those of them that have chosen LSE or LSI, which run on in Stop mode.
        ahb: HCLK cycles per tick of AHB; above 1 only where the CPU has a clock of its own, which counts as HCLK here.
    """

    all_timers: bool
    kernels: Mapping[str, Fraction] = field(default_factory=dict)
    in_stop: frozenset[str] = frozenset()
    ahb: int = 1

    def timer(self, divider: int) -> int:
        """Return HCLK cycles per tick of the timers on a bus with that divider (RM0410 5.2.10, RM0433 8.5.8)."""
        return self.ahb * max(divider // self.ahb // (4 if self.all_timers else 2), 1)


AnyRates = TypeVar("AnyRates", bound=BusRates)
AnyKernelRates = TypeVar("AnyKernelRates", bound=KernelRates)


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


@dataclass(frozen=True, slots=True)
class KernelChoice:
    """The field of a register that says on which clock a peripheral runs.

    Attributes:
        register: its name.
        shift: lowest bit.
        mask: its bits, shifted down.
        clocks: for each value, the name of a clock.
    """

    register: str
    shift: int
    mask: int
    clocks: tuple[str, ...]


class KernelClockTree(BasicClockTree[AnyKernelRates]):
    """The present rates, those of the peripherals' own clocks too; see `BasicClockTree`."""

    def __init__(self, rates: AnyKernelRates) -> None:
        self._kernel: dict[str, Fraction] = {}
        super().__init__(rates)

    def set(self, rates: AnyKernelRates, *, stopped: bool) -> None:
        """Take over new rates, those of the kernel clocks too."""
        super().set(rates, stopped=stopped)
        self._kernel = {
            name: rates.hclk / rate if rate and not stopped else Fraction(0) for name, rate in rates.kernels.items()
        }

    def kernel(self, peripheral: str) -> Fraction:
        """Return HCLK cycles per tick of a peripheral's own clock; 0 in Stop mode, or while its source does not run."""
        return self._kernel[peripheral]

    def kernel_hz(self, peripheral: str) -> Fraction:
        """Return the rate of a peripheral's own clock; 0 in Stop mode, or while its source does not run."""
        return Fraction(0) if self.stopped else self.rates.kernels[peripheral]

    def low_power_hz(self, peripheral: str) -> Fraction:
        """Return the rate of the clock of a peripheral that goes on counting in Stop mode if that clock does."""
        return self.rates.kernels[peripheral] if peripheral in self.rates.in_stop else self.kernel_hz(peripheral)
