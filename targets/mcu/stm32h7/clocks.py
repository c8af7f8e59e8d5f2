"""The clock tree of the STM32H743 and H753 as arithmetic: from the registers of RCC to exact rates (RM0433 8.5).

The CPU has a clock of its own, SYSCLK behind D1CPRE, which is the tick of this emulation (`BusRates.hclk`); HPRE
divides it for the buses, which the manual calls HCLK, and D1PPRE, D2PPRE1, D2PPRE2 and D3PPRE that again, for APB3,
APB1, APB2 and APB4.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from types import MappingProxyType

from targets.mcu.stm32.clock_tree import AHB_DIVIDERS, APB_DIVIDERS, KernelChoice, KernelClockTree, KernelRates

__all__ = [
    "CSI_HZ",
    "HSI48_HZ",
    "HSI_HZ",
    "KERNEL_CHOICES",
    "LSI_HZ",
    "ClockTree",
    "PllRates",
    "Rates",
    "Source",
    "pll_rates",
    "rates_of",
]

HSI_HZ = Fraction(64_000_000)  # before HSIDIV; RM0433 section 8.5.2
CSI_HZ = Fraction(4_000_000)
HSI48_HZ = Fraction(48_000_000)
LSI_HZ = Fraction(32_000)
FRACTIONS = 1 << 13  # of FRACN


class Source(enum.IntEnum):
    """What drives SYSCLK; the values of CFGR.SW and SWS. Those of PLLCKSELR.PLLSRC are the first three of them."""

    HSI = 0
    CSI = 1
    HSE = 2
    PLL1 = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class PllRates:
    """What a PLL makes, in hertz; 0 from an output that is not enabled.

    Attributes:
        entry: behind the divider DIVM; 0 with DIVM = 0, which switches it off.
        vco: of the oscillator: entry times DIVN + 1 and the fraction.
        p: VCO / (DIVP + 1), and so for q and r.
        q: see p.
        r: see p.
    """

    entry: Fraction
    vco: Fraction
    p: Fraction
    q: Fraction
    r: Fraction


def pll_rates(source_hz: Fraction, divm: int, dividers: int, fraction: int, enabled: int) -> PllRates:
    """Return the rates of a PLL (RM0433 sections 8.7.11 to 8.7.18).

    Args:
        source_hz: what PLLSRC selects.
        divm: DIVM.
        dividers: PLLxDIVR.
        fraction: FRACN as the modulator has it.
        enabled: DIVPEN, DIVQEN and DIVREN, from bit 0 on.
    """
    none = Fraction(0)
    entry = source_hz / divm if divm else none
    vco = entry * ((dividers & 0x1FF) + 1 + Fraction(fraction, FRACTIONS))
    outputs = (vco / ((dividers >> shift & 0x7F) + 1) for shift in (9, 16, 24))
    p, q, r = (output if enabled >> index & 1 else none for index, output in enumerate(outputs))
    return PllRates(entry=entry, vco=vco, p=p, q=q, r=r)


_SERIAL = ("PLL2 Q", "PLL3 Q", "HSI", "CSI", "LSE", "-", "-")
_AUDIO = ("PLL1 Q", "PLL2 P", "PLL3 P", "I2S_CKIN", "PER", "-", "-", "-")
_LPTIM = ("PLL2 P", "PLL3 R", "LSE", "LSI", "PER", "-", "-")
_SPI = ("PLL2 Q", "PLL3 Q", "HSI", "CSI", "HSE", "-", "-")
_MEMORY = ("AHB", "PLL1 Q", "PLL2 R", "PER")

# RM0433 sections 8.7.19 to 8.7.22, by register: peripherals, lowest bit, clocks by value; "-" is none or reserved.
_CHOICES: Mapping[str, tuple[tuple[tuple[str, ...], int, tuple[str, ...]], ...]] = {
    "D1CCIPR": (
        (("FMC",), 0, _MEMORY),
        (("QUADSPI",), 4, _MEMORY),
        (("SDMMC1", "SDMMC2"), 16, ("PLL1 Q", "PLL2 R")),
    ),
    "D2CCIP1R": (
        (("SAI1",), 0, _AUDIO),
        (("SAI2", "SAI3"), 6, _AUDIO),
        (("SPI1", "SPI2", "SPI3"), 12, _AUDIO),
        (("SPI4", "SPI5"), 16, ("APB2", *_SPI)),
        (("SPDIFRX",), 20, ("PLL1 Q", "PLL2 R", "PLL3 R", "HSI")),
        (("DFSDM1",), 24, ("APB2", "SYSCLK")),
        (("FDCAN1", "FDCAN2"), 28, ("HSE", "PLL1 Q", "PLL2 Q", "-")),
        (("SWPMI1",), 31, ("APB1", "HSI")),
    ),
    "D2CCIP2R": (
        (("USART2", "USART3", "UART4", "UART5", "UART7", "UART8"), 0, ("APB1", *_SERIAL)),
        (("USART1", "USART6"), 3, ("APB2", *_SERIAL)),
        (("RNG",), 8, ("HSI48", "PLL1 Q", "LSE", "LSI")),
        (("I2C1", "I2C2", "I2C3"), 12, ("APB1", "PLL3 R", "HSI", "CSI")),
        (("USB1_OTG_HS", "USB2_OTG_HS"), 20, ("-", "PLL1 Q", "PLL3 Q", "HSI48")),
        (("CEC",), 22, ("LSE", "LSI", "CSI/122", "-")),
        (("LPTIM1",), 28, ("APB1", *_LPTIM)),
    ),
    "D3CCIPR": (
        (("LPUART1",), 0, ("APB4", *_SERIAL)),
        (("I2C4",), 8, ("APB4", "PLL3 R", "HSI", "CSI")),
        (("LPTIM2",), 10, ("APB4", *_LPTIM)),
        (("LPTIM3", "LPTIM4", "LPTIM5"), 13, ("APB4", *_LPTIM)),
        (("ADC12", "ADC3"), 16, ("PLL2 P", "PLL3 R", "PER", "-")),
        (("SAI4_A",), 21, _AUDIO),
        (("SAI4_B",), 24, _AUDIO),
        (("SPI6",), 28, ("APB4", *_SPI)),
    ),
}

KERNEL_CHOICES: Mapping[str, KernelChoice] = MappingProxyType(
    {
        name: KernelChoice(register, shift, len(clocks) - 1, clocks)
        for register, fields in _CHOICES.items()
        for names, shift, clocks in fields
        for name in names
    }
)
"""The field that chooses its clock, by peripheral."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rates(KernelRates):
    """Rates in hertz, and the dividers from the CPU's clock to the buses; see `KernelRates`.

    Attributes:
        apb3: CPU cycles per tick of PCLK3.
        apb4: CPU cycles per tick of PCLK4.
    """

    apb3: int
    apb4: int

    def dividers(self) -> Mapping[str, int]:
        """Return CPU cycles per tick of each bus by its name."""
        return {"AHB": self.ahb, "APB1": self.apb1, "APB2": self.apb2, "APB3": self.apb3, "APB4": self.apb4}

    @property
    def bus_hz(self) -> Fraction:
        """Rate of AHB and AXI, which the manual calls HCLK."""
        return self.hclk / self.ahb


def rates_of(sysclk: Fraction, d1cfgr: int, d2cfgr: int, d3cfgr: int, *, all_timers: bool) -> Rates:
    """Return the rates for SYSCLK and the registers with prescalers, without those of kernel clocks."""
    ahb = AHB_DIVIDERS[d1cfgr & 0xF]
    return Rates(
        sysclk=sysclk,
        hclk=sysclk / AHB_DIVIDERS[d1cfgr >> 8 & 0xF],
        ahb=ahb,
        apb1=ahb * APB_DIVIDERS[d2cfgr >> 4 & 7],
        apb2=ahb * APB_DIVIDERS[d2cfgr >> 8 & 7],
        apb3=ahb * APB_DIVIDERS[d1cfgr >> 4 & 7],
        apb4=ahb * APB_DIVIDERS[d3cfgr >> 4 & 7],
        all_timers=all_timers,
    )


class ClockTree(KernelClockTree[Rates]):
    """The present rates, as the peripherals ask for them; implements `services.Clocks`. See `BasicClockTree`."""

    def __init__(self) -> None:
        super().__init__(rates_of(HSI_HZ, 0, 0, 0, all_timers=False))
