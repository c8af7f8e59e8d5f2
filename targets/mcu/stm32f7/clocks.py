"""The clock tree of the STM32F76x as arithmetic: from the registers of RCC to exact rates (RM0410 section 5.2)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from types import MappingProxyType

from targets.mcu.stm32.clock_tree import AHB_DIVIDERS, APB_DIVIDERS, KernelChoice, KernelClockTree, KernelRates
from targets.mcu.stm32.rcc_classic import Source

__all__ = [
    "HSI_HZ",
    "LSI_HZ",
    "ClockTree",
    "KernelChoice",
    "PllRates",
    "Rates",
    "kernel_choices",
    "pll_rates",
    "rates_of",
]

HSI_HZ = Fraction(16_000_000)  # RM0410 section 5.2.2
LSI_HZ = Fraction(32_000)  # RM0410 section 5.2.5; DS11532: 17 to 47 kHz
PLLSRC = 1 << 22

Rates = KernelRates


@dataclass(frozen=True, slots=True, kw_only=True)
class PllRates:
    """What a PLL makes, in hertz; 0 from a divider with a value that is not allowed.

    Attributes:
        entry: behind the divider M.
        vco: of the oscillator: entry times N.
        p: VCO / 2, 4, 6 or 8.
        q: VCO / 2 to 15.
        r: VCO / 2 to 7.
    """

    entry: Fraction
    vco: Fraction
    p: Fraction
    q: Fraction
    r: Fraction


def pll_rates(pllcfgr: int, hse_hz: Fraction, multiplier: int | None = None) -> PllRates:
    """Return the rates of a PLL (RM0410 sections 5.3.2, 5.3.24, 5.3.25).

    Args:
        pllcfgr: RCC_PLLCFGR, whose M and source serve all three PLLs.
        hse_hz: rate of the HSE.
        multiplier: the register with N, P, Q and R, if it is another.
    """
    source = hse_hz if pllcfgr & PLLSRC else HSI_HZ
    entry = source / max(pllcfgr & 0x3F, 1)
    own = pllcfgr if multiplier is None else multiplier
    vco = entry * (own >> 6 & 0x1FF)
    q, r = own >> 24 & 0xF, own >> 28 & 7
    none = Fraction(0)
    return PllRates(
        entry=entry,
        vco=vco,
        p=vco / (2 * (own >> 16 & 3) + 2),
        q=vco / q if q > 1 else none,
        r=vco / r if r > 1 else none,
    )


def kernel_choices() -> Mapping[str, KernelChoice]:
    """Return the choices of RCC_DCKCFGR2 by peripheral (RM0410 section 5.3.27); ``-`` is a reserved value."""
    found = {}
    usarts = ("USART1", "USART2", "USART3", "UART4", "UART5", "USART6", "UART7", "UART8")
    for index, name in enumerate(usarts):
        bus = "APB2" if name in ("USART1", "USART6") else "APB1"
        found[name] = KernelChoice("DCKCFGR2", 2 * index, 3, (bus, "SYSCLK", "HSI", "LSE"))
    for index in range(4):
        found[f"I2C{index + 1}"] = KernelChoice("DCKCFGR2", 16 + 2 * index, 3, ("APB1", "SYSCLK", "HSI", "-"))
    found["LPTIM1"] = KernelChoice("DCKCFGR2", 24, 3, ("APB1", "LSI", "HSI", "LSE"))
    found["CEC"] = KernelChoice("DCKCFGR2", 26, 1, ("LSE", "HSI/488"))
    for name in ("RNG", "USB_OTG_FS"):
        found[name] = KernelChoice("DCKCFGR2", 27, 1, ("PLL Q", "PLLSAI P"))
    for index, name in enumerate(("SDMMC1", "SDMMC2")):
        found[name] = KernelChoice("DCKCFGR2", 28 + index, 1, ("CK48", "SYSCLK"))
    return MappingProxyType(found)


def rates_of(cfgr: int, source: Source, hse_hz: Fraction, pll: PllRates, *, all_timers: bool) -> Rates:
    """Return the rates for a value of RCC_CFGR with `source` driving SYSCLK, without those of kernel clocks."""
    sysclk = {Source.HSI: HSI_HZ, Source.HSE: hse_hz, Source.PLL: pll.p}[source]
    return Rates(
        sysclk=sysclk,
        hclk=sysclk / AHB_DIVIDERS[cfgr >> 4 & 0xF],
        apb1=APB_DIVIDERS[cfgr >> 10 & 7],
        apb2=APB_DIVIDERS[cfgr >> 13 & 7],
        all_timers=all_timers,
    )


class ClockTree(KernelClockTree[Rates]):
    """The present rates, as the peripherals ask for them; implements `services.Clocks`. See `BasicClockTree`."""

    def __init__(self) -> None:
        super().__init__(Rates(sysclk=HSI_HZ, hclk=HSI_HZ, apb1=1, apb2=1, all_timers=False))
