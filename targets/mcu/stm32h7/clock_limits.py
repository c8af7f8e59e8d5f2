"""What the clocks of an STM32H743 or H753 of revision V may not exceed (RM0433 sections 4.3.8 and 6.6.1; DS12117).

The voltage scale is a number from 0 to 3; 0 is scale 1 with over-drive.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from targets.mcu.stm32h7.clocks import PllRates, Rates

__all__ = ["needed_wait_states", "pll_violations", "violations"]

MHZ = 1_000_000
# RM0433, FLASH recommended number of wait states: up to which rate of AXI 0, 1, 2 ... of them do, by scale.
_WAIT_STATES = {
    0: (70, 140, 210, 225, 240),
    1: (70, 140, 210, 225, 240),
    2: (55, 110, 165, 225),
    3: (45, 90, 135, 180, 225),
}
# DS12117, general operating conditions: CPU, AHB and AXI, APB by scale. For APB it has 50 MHz at scale 3, in which the
# chip starts with 64 MHz: these are let pass (choice).
_MOST_MHZ = {0: (480, 240, 120), 1: (400, 200, 100), 2: (300, 150, 75), 3: (200, 100, 64)}
_ENTRIES_MHZ = ((1, 2), (2, 4), (4, 8), (8, 16))  # by RGE
_VCO_MHZ = ((192, 960), (150, 420))  # by VCOSEL


def needed_wait_states(bus_hz: Fraction, scale: int) -> int:
    """Return the flash wait states that a rate of AXI asks for."""
    steps = _WAIT_STATES[scale]
    return next((count for count, most in enumerate(steps) if bus_hz <= most * MHZ), len(steps))


def pll_violations(
    number: int, rates: PllRates, entry_range: int, vco_choice: int, p_divider: int
) -> Iterator[tuple[str, str]]:
    """Yield (field, what is wrong) for settings of a PLL out of their range (RM0433 sections 8.5.5 and 8.7.12).

    Args:
        number: 1 to 3.
        rates: what the settings make.
        entry_range: RGE.
        vco_choice: VCOSEL.
        p_divider: by what the VCO is divided for P.
    """
    low, high = _ENTRIES_MHZ[entry_range]
    if not low * MHZ <= rates.entry <= high * MHZ:
        text = f"the input of PLL{number} is {_mhz(rates.entry)} MHz; PLL{number}RGE says {low} to {high} MHz"
        yield f"PLLCFGR.PLL{number}RGE", text
    low, high = _VCO_MHZ[vco_choice]
    if not low * MHZ <= rates.vco <= high * MHZ:
        text = f"the VCO of PLL{number} runs at {_mhz(rates.vco)} MHz; it must be between {low} and {high} MHz"
        yield f"PLL{number}DIVR.DIVN{number}", text
    if number == 1 and p_divider > 1 and p_divider % 2:
        yield "PLL1DIVR.DIVP1", f"PLL1 divides by 1 or by even numbers for P, not by {p_divider}"


def violations(rates: Rates, scale: int) -> Iterator[tuple[str, str]]:
    """Yield (register and field, what is wrong) for every limit that `rates` exceeds."""
    cpu, bus, apb = _MOST_MHZ[scale]
    for where, clock, rate, most in (
        ("CFGR.SW", "the CPU", rates.hclk, cpu),
        ("D1CFGR.HPRE", "HCLK", rates.bus_hz, bus),
        ("D2CFGR.D2PPRE1", "PCLK1", rates.pclk1, apb),
        ("D2CFGR.D2PPRE2", "PCLK2", rates.pclk2, apb),
        ("D1CFGR.D1PPRE", "PCLK3", rates.hclk / rates.apb3, apb),
        ("D3CFGR.D3PPRE", "PCLK4", rates.hclk / rates.apb4, apb),
    ):
        if rate > most * MHZ:
            yield where, f"{clock} runs at {_mhz(rate)} MHz, above the {most} MHz of voltage scale {scale}"


def _mhz(rate: Fraction) -> str:
    return f"{float(rate / MHZ):g}"
