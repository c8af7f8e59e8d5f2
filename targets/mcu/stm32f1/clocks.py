"""The clock tree of the STM32F103 as arithmetic: from RCC_CFGR to exact rates (RM0008 section 7.2, figure 8)."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from targets.mcu.stm32.clock_tree import AHB_DIVIDERS, APB_DIVIDERS, BasicClockTree, BusRates
from targets.mcu.stm32.rcc_classic import Source

__all__ = ["HSI_HZ", "LSI_HZ", "ClockTree", "Rates", "pll_hz", "rates_of"]

HSI_HZ = Fraction(8_000_000)  # RM0008 section 7.2.2
LSI_HZ = Fraction(40_000)  # RM0008 section 7.2.5: around 40 kHz, between 30 and 60 kHz; the table of the IWDG uses 40
PLLSRC, PLLXTPRE, USBPRE = 1 << 16, 1 << 17, 1 << 22


@dataclass(frozen=True, slots=True, kw_only=True)
class Rates(BusRates):
    """Rates in hertz, and the dividers from HCLK to the two peripheral buses; see `BusRates`.

    Attributes:
        adc: clock of the converters.
        usb: clock of USB, while the PLL runs.
    """

    adc: Fraction
    usb: Fraction


def pll_hz(cfgr: int, hse_hz: Fraction, prediv: int | None = None) -> Fraction:
    """Return the rate of the PLL as CFGR configures it: HSI / 2, HSE or HSE / 2, times 2 to 16.

    Chips with RCC_CFGR2 have a divider `prediv` of HSE there, instead of PLLXTPRE.
    """
    if cfgr & PLLSRC:
        entry = hse_hz / (prediv or (2 if cfgr & PLLXTPRE else 1))
    else:
        entry = HSI_HZ / 2
    return entry * min((cfgr >> 18 & 0xF) + 2, 16)  # both 1110 and 1111 are times 16


def rates_of(cfgr: int, source: Source, hse_hz: Fraction, prediv: int | None = None) -> Rates:
    """Return all rates for a value of RCC_CFGR with `source` driving SYSCLK; `prediv` as for `pll_hz`."""
    pll = pll_hz(cfgr, hse_hz, prediv)
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


class ClockTree(BasicClockTree[Rates]):
    """The present rates, as the peripherals ask for them; implements `services.Clocks`. See `BasicClockTree`."""

    def __init__(self) -> None:
        super().__init__(rates_of(0, Source.HSI, HSI_HZ))

    def kernel(self, peripheral: str) -> Fraction:
        """Return HCLK cycles per tick of the clock of the converters, ``ADC``; all others run on that of their bus."""
        if peripheral != "ADC":
            raise KeyError(peripheral)
        return Fraction(0) if self.stopped else self.rates.hclk / self.rates.adc
