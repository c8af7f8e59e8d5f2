"""The three PLLs of the STM32H743 and H753 in RCC: settings, when they hold, what they make (RM0433 section 8.5.5).

All run on the same source behind a divider of their own. While a PLL is on its settings keep their values, but for
FRACN: the modulator takes it over on the rising edge of FRACEN, on the fly.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Unpack

from targets.mcu.services import Services
from targets.mcu.stm32.rcc import BasicRcc, BoardClocks
from targets.mcu.stm32h7 import rcc_registers as at
from targets.mcu.stm32h7.clock_limits import pll_violations
from targets.mcu.stm32h7.clocks import CSI_HZ, HSI_HZ, PllRates, Source, pll_rates

__all__ = ["PLLS", "RccWithPlls"]

PLLS = ("PLL1", "PLL2", "PLL3")
_OF_ONE, _FRACEN = 0xF, 1 << 0  # a PLL's bits of PLLCFGR, shifted down


class RccWithPlls(BasicRcc):
    """The part of RCC that has to do with the PLLs; see `BasicRcc`."""

    def __init__(self, base: int, services: Services, **board: Unpack[BoardClocks]) -> None:
        self._fractions = [0, 0, 0]  # what the modulators have taken over
        super().__init__(base, services, **board)

    # --- registers

    def write_PLLCKSELR(self, value: int) -> None:
        """The source of all PLLs, and their entry dividers; only while they are off."""
        fixed = 0x3 if any(self._pll_on(index) for index in range(3)) else 0
        fixed |= sum(0x3F << 4 + 8 * index for index in range(3) if self._pll_on(index))
        self._write_settings(at.PLLCKSELR, value, fixed)
        self._feed_plls()

    def write_PLLCFGR(self, value: int) -> None:
        """Ranges and outputs, only while a PLL is off; FRACEN, on whose rising edge FRACN is taken over."""
        old, fixed = self[at.PLLCFGR], 0
        for index in range(3):
            if self._pll_on(index):
                fixed |= (_OF_ONE & ~_FRACEN) << 4 * index | 7 << 16 + 3 * index
            if value & ~old & _FRACEN << 4 * index:
                self._fractions[index] = self[at.PLLFRACR[index]] >> 3
        self._write_settings(at.PLLCFGR, value, fixed)
        self._set_tree()

    def write_PLL1DIVR(self, value: int) -> None:
        """Multiplier and dividers of PLL1."""
        self._write_dividers(0, value)

    def write_PLL2DIVR(self, value: int) -> None:
        """Multiplier and dividers of PLL2."""
        self._write_dividers(1, value)

    def write_PLL3DIVR(self, value: int) -> None:
        """Multiplier and dividers of PLL3."""
        self._write_dividers(2, value)

    def _write_dividers(self, index: int, value: int) -> None:
        self._write_settings(at.PLLDIVR[index], value, 0xFFFF_FFFF if self._pll_on(index) else 0)

    def _write_settings(self, offset: int, value: int, fixed: int) -> None:
        if (value ^ self[offset]) & fixed:
            self.note("misuse", self.registers[offset].name, "a PLL is on: its settings keep their values")
        self[offset] = (value & ~fixed) | (self[offset] & fixed)

    def _pll_on(self, index: int) -> bool:
        return bool(self[at.CR] & at.PLLON[index])

    # --- what feeds them, and what they make

    def _pll_source(self) -> Source | None:
        choice = self[at.PLLCKSELR] & 3
        return Source(choice) if choice < Source.PLL1 else None

    def _some_pll_runs_on(self, source: Source) -> bool:
        return self._pll_source() is source and any(self._pll_on(index) for index in range(3))

    def _feed_plls(self) -> None:
        source = self._pll_source()
        for index, name in enumerate(PLLS):
            on = self._pll_on(index) and source is not None and self._oscillators[source.name].ready
            if on and not self._oscillators[name].on:
                self._check_pll(index)
            self._oscillators[name].switch(on)

    def _pll_rates(self, index: int) -> PllRates:
        source = self._pll_source()
        return pll_rates(
            Fraction(0) if source is None else self._rate_of(source),
            self[at.PLLCKSELR] >> 4 + 8 * index & 0x3F,
            self[at.PLLDIVR[index]],
            self._fractions[index],
            self[at.PLLCFGR] >> 16 + 3 * index & 7,
        )

    def _rate_of(self, source: Source) -> Fraction:
        hsi = HSI_HZ / (1 << (self[at.CR] >> 3 & 3))
        return {Source.HSI: hsi, Source.CSI: CSI_HZ, Source.HSE: self.hse_hz}[source]

    def _check_pll(self, index: int) -> None:
        settings, p_divider = self[at.PLLCFGR] >> 4 * index, (self[at.PLLDIVR[index]] >> 9 & 0x7F) + 1
        rates = self._pll_rates(index)
        for field, text in pll_violations(index + 1, rates, settings >> 2 & 3, settings >> 1 & 1, p_divider):
            self.note("misuse", field, text)
