"""What the clocks of an STM32F76x may not exceed (RM0410 sections 3.3.2, 4.1.4, 5.3.2; DS11532)."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from targets.mcu.stm32f7.clocks import PllRates, Rates

__all__ = ["highest_hclk_mhz", "needed_wait_states", "pll_violations", "violations"]

MHZ = 1_000_000
MHZ_PER_WAIT_STATE = 30  # RM0410 table 7, at 2.7 to 3.6 V


def needed_wait_states(hclk: Fraction) -> int:
    """Return the flash wait states that a rate of HCLK asks for at 3.3 V: one for each 30 MHz above the first."""
    return max(0, -(-hclk // (MHZ_PER_WAIT_STATE * MHZ)) - 1)


def highest_hclk_mhz(scale: int, *, over_drive: bool) -> int:
    """Return the highest HCLK at a voltage scale, 1 to 3 (RM0410 section 4.1.4; DS11532, operating conditions)."""
    return {1: 216 if over_drive else 180, 2: 180 if over_drive else 168, 3: 144}[scale]


def pll_violations(name: str, rates: PllRates, multiplier: int) -> Iterator[tuple[str, str]]:
    """Yield (field, what is wrong) for settings of a PLL out of their range (RM0410 section 5.3.2)."""
    if not MHZ * Fraction(95, 100) <= rates.entry <= MHZ * Fraction(21, 10):
        yield "PLLM", f"the input of {name} is {_mhz(rates.entry)} MHz; it must be between 1 and 2 MHz"
    if not 50 <= multiplier <= 432:
        yield "PLLN", f"{multiplier} is a wrong value; it must be between 50 and 432"
    elif not 100 * MHZ <= rates.vco <= 432 * MHZ:
        yield "PLLN", f"the VCO of {name} runs at {_mhz(rates.vco)} MHz; it must be between 100 and 432 MHz"


def violations(rates: Rates, *, scale: int, over_drive: bool) -> Iterator[tuple[str, str]]:
    """Yield (register and field, what is wrong) for every limit that `rates` exceeds."""
    limit_mhz = highest_hclk_mhz(scale, over_drive=over_drive)
    if rates.hclk > limit_mhz * MHZ:
        how = f"voltage scale {scale}{' and over-drive' if over_drive else ''}"
        yield "CFGR.SW", f"HCLK runs at {_mhz(rates.hclk)} MHz, above the {limit_mhz} MHz of {how}"
    # DS11532, operating conditions: 54 and 108 MHz with over-drive, 45 and 90 MHz without
    for field, clock, rate, most in (
        ("CFGR.PPRE1", "PCLK1", rates.pclk1, 54 if over_drive else 45),
        ("CFGR.PPRE2", "PCLK2", rates.pclk2, 108 if over_drive else 90),
    ):
        if rate > most * MHZ:
            yield field, f"{clock} runs at {_mhz(rate)} MHz, above the {most} MHz this chip is made for"


def _mhz(rate: Fraction) -> str:
    return f"{float(rate / MHZ):g}"
