"""What the clocks of an STM32F103 may not exceed (DS5319 sections 5.3.1 and 5.3.8; RM0008 sections 7.2 and 3.3.3)."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from targets.mcu.stm32f1.clocks import Rates
from targets.mcu.stm32f1.densities import MEDIUM, Limits

__all__ = ["needed_wait_states", "violations"]

MHZ = 1_000_000
USB_HZ = 48 * MHZ


def needed_wait_states(sysclk: Fraction) -> int:
    """Return the flash wait states that a rate of SYSCLK asks for (RM0008 section 3.3.3: 24 and 48 MHz)."""
    if sysclk <= 24 * MHZ:
        return 0
    return 1 if sysclk <= 48 * MHZ else 2


def violations(
    rates: Rates, *, adc_on: bool, usb_on: bool, limits: Limits = MEDIUM.limits
) -> Iterator[tuple[str, str]]:
    """Yield (register and field, what is wrong) for every limit that `rates` exceeds."""
    highest = (
        ("CFGR.SW", "SYSCLK", rates.sysclk, limits.sysclk),
        ("CFGR.PPRE1", "PCLK1", rates.pclk1, limits.pclk1),
        ("CFGR.PPRE2", "PCLK2", rates.pclk2, limits.sysclk),
    )
    for where, clock, rate, limit_mhz in highest:
        if rate > limit_mhz * MHZ:
            yield where, f"{clock} runs at {_mhz(rate)} MHz, above the {limit_mhz} MHz this chip is made for"
    if adc_on and rates.adc > limits.adc * MHZ:
        yield "CFGR.ADCPRE", f"ADCCLK runs at {_mhz(rates.adc)} MHz, above {limits.adc} MHz"
    if usb_on and rates.usb != USB_HZ:
        yield "CFGR.USBPRE", f"the USB clock is {_mhz(rates.usb)} MHz; USB works at 48 MHz only"


def _mhz(rate: Fraction) -> str:
    return f"{float(rate / MHZ):g}"
