"""The clock tree of the STM32F103 as arithmetic: from RCC_CFGR to exact rates (RM0008 section 7.2, figure 8)."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from targets.mcu.stm32.rcc import Source

__all__ = ["HSI_HZ", "LSI_HZ", "ClockTree", "Rates", "pll_hz", "rates_of"]

HSI_HZ = Fraction(8_000_000)  # RM0008 section 7.2.2
LSI_HZ = Fraction(40_000)  # RM0008 section 7.2.5: around 40 kHz, between 30 and 60 kHz; the table of the IWDG uses 40
PLLSRC, PLLXTPRE, USBPRE = 1 << 16, 1 << 17, 1 << 22
AHB_DIVIDERS = (1, 1, 1, 1, 1, 1, 1, 1, 2, 4, 8, 16, 64, 128, 256, 512)
APB_DIVIDERS = (1, 1, 1, 1, 2, 4, 8, 16)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rates:
    """Rates in hertz, and the dividers from HCLK to the two peripheral buses.

    Attributes:
        sysclk: before the AHB prescaler.
        hclk: CPU, memory, DMA.
        apb1: HCLK cycles per tick of PCLK1.
        apb2: HCLK cycles per tick of PCLK2.
        adc: clock of the converters.
        usb: clock of USB, while the PLL runs.
    """

    sysclk: Fraction
    hclk: Fraction
    apb1: int
    apb2: int
    adc: Fraction
    usb: Fraction

    @property
    def pclk1(self) -> Fraction:
        """Rate of PCLK1."""
        return self.hclk / self.apb1

    @property
    def pclk2(self) -> Fraction:
        """Rate of PCLK2."""
        return self.hclk / self.apb2


def pll_hz(cfgr: int, hse_hz: Fraction) -> Fraction:
    """Return the rate of the PLL as CFGR configures it: HSI / 2, HSE or HSE / 2, times 2 to 16."""
    if cfgr & PLLSRC:
        entry = hse_hz / 2 if cfgr & PLLXTPRE else hse_hz
    else:
        entry = HSI_HZ / 2
    return entry * min((cfgr >> 18 & 0xF) + 2, 16)  # both 1110 and 1111 are times 16


def rates_of(cfgr: int, source: Source, hse_hz: Fraction) -> Rates:
    """Return all rates for a value of RCC_CFGR with `source` driving SYSCLK."""
    pll = pll_hz(cfgr, hse_hz)
    sysclk = {Source.HSI: HSI_HZ, Source.HSE: hse_hz, Source.PLL: pll}[source]
    hclk = sysclk / AHB_DIVIDERS[cfgr >> 4 & 0xF]
    apb2 = APB_DIVIDERS[cfgr >> 11 & 7]
    return Rates(
        sysclk=sysclk,
        hclk=hclk,
        apb1=APB_DIVIDERS[cfgr >> 8 & 7],
        apb2=apb2,
        adc=hclk / apb2 / (2 * (cfgr >> 14 & 3) + 2),
        usb=pll if cfgr & USBPRE else pll * Fraction(2, 3),
    )


class ClockTree:
    """The present rates, as the peripherals ask for them; implements `services.Clocks`. RCC sets them.

    Attributes:
        rates: the present rates.
        stopped: Stop mode: every derived clock stands still.
    """

    def __init__(self) -> None:
        self.rates = rates_of(0, Source.HSI, HSI_HZ)
        self.stopped = False
        self._pclk: dict[str, int] = {}
        self._timer: dict[str, int] = {}
        self.set(self.rates, stopped=False)

    def set(self, rates: Rates, *, stopped: bool) -> None:
        """Take over new rates."""
        self.rates = rates
        self.stopped = stopped
        dividers = {"AHB": 1, "APB1": rates.apb1, "APB2": rates.apb2}
        for bus, divider in dividers.items():
            self._pclk[bus] = 0 if stopped else divider
            # The timers run at twice the bus clock unless its prescaler is 1 (RM0008 section 7.2, figure 8).
            self._timer[bus] = 0 if stopped else max(divider // 2, 1)

    def pclk(self, bus: str) -> int:
        """Return HCLK cycles per tick of the bus clock; 0 in Stop mode."""
        return self._pclk[bus]

    def timer(self, bus: str) -> int:
        """Return HCLK cycles per tick of the timers' clock on that bus; 0 in Stop mode."""
        return self._timer[bus]

    def kernel(self, peripheral: str) -> Fraction:
        """Every peripheral runs on the clock of its bus."""
        raise KeyError(peripheral)
