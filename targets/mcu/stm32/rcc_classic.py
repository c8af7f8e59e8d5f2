"""RCC of the families with one PLL for SYSCLK, F1 and F7: CR, CFGR and CIR (RM0008 section 7, RM0410 section 5).

Choices where the manuals are silent: SYSCLK switches at once when the wanted source is ready; SW = 11 is not taken
over.
"""

from __future__ import annotations

import abc
import enum
from typing import ClassVar, Unpack

from targets.mcu.services import Services
from targets.mcu.stm32.oscillator import Oscillator
from targets.mcu.stm32.rcc import LSERDY, LSION, LSIRDY, BasicRcc, BoardClocks

__all__ = ["CR_BITS", "CSR_BITS", "ClassicRcc", "Source", "ready_bits"]

CR = 0x00
HSION, HSIRDY, HSEON, HSERDY, HSEBYP, CSSON = 1 << 0, 1 << 1, 1 << 16, 1 << 17, 1 << 18, 1 << 19
PLLON, PLLRDY = 1 << 24, 1 << 25
SW = 0x3
RMVF = 1 << 24
CSSF = 1 << 7
CR_BITS = HSION | 0xF8 | HSEON | HSEBYP | CSSON | PLLON
CSR_BITS = LSION | RMVF
"""The bits of these registers that can be written in both families."""
DEFAULT_TRIM = 0x10


class Source(enum.IntEnum):
    """What drives SYSCLK; the values of CFGR.SW and SWS."""

    HSI = 0
    HSE = 1
    PLL = 2


def ready_bits(bdcr: int, csr: int) -> dict[str, tuple[int, int, int]]:
    """Return what both families have of `BasicRcc.READY`, by the offsets of BDCR and CSR."""
    return {
        "LSI": (1 << 0, csr, LSIRDY),
        "LSE": (1 << 1, bdcr, LSERDY),
        "HSI": (1 << 2, CR, HSIRDY),
        "HSE": (1 << 3, CR, HSERDY),
        "PLL": (1 << 4, CR, PLLRDY),
    }


class ClassicRcc(BasicRcc):
    """Reset and clock control with one PLL for SYSCLK; a family says where its registers are; see `BasicRcc`.

    Attributes:
        CFGR, CIR: offsets of registers.
    """

    CFGR: ClassVar[int]
    CIR: ClassVar[int]

    def __init__(self, base: int, services: Services, **board: Unpack[BoardClocks]) -> None:
        self._source = Source.HSI
        super().__init__(base, services, **board)

    @property
    def _pll(self) -> Oscillator:
        return self._oscillators["PLL"]

    # --- what a family says

    @abc.abstractmethod
    def _pll_runs_on_hse(self) -> bool:
        """Say whether the HSE is selected as the source of the PLL."""

    @abc.abstractmethod
    def _check_pll(self) -> None:
        """Note what is wrong with the settings of the PLL, which is about to start."""

    # --- resets and Stop mode

    def _forget_source(self) -> None:
        self._source = Source.HSI

    def _stop_oscillators(self) -> None:
        self[CR] &= ~(HSEON | PLLON)
        self._pll.stop_now()
        self._hse.stop_now()

    def _back_to_start(self) -> None:
        self[CR] |= HSION
        self[self.CFGR] &= ~0xF
        self._hsi.run_now()
        self._source = Source.HSI

    # --- registers

    def write_CR(self, value: int) -> None:
        """HSION, HSEON, CSSON, PLLON; what drives SYSCLK, or is selected to, cannot be switched off."""
        kept = self._needed_bits() & self[CR] & ~value
        if kept:
            self.note("misuse", "CR", f"bits 0x{kept:X}: an oscillator that drives SYSCLK cannot be switched off")
        value |= kept
        if (value ^ self[CR]) & HSEBYP and self[CR] & HSEON:
            self.note("misuse", "CR.HSEBYP", "can be changed only while HSEON = 0; it keeps its value")
            value ^= HSEBYP
        if value & HSEON & ~self[CR] and self._hse_is_clock and not value & HSEBYP:
            self.note("assumed", "CR.HSEBYP", "OSC_IN is driven by a clock: the oscillator is assumed to pass it on")
        if value >> 3 & 0x1F != DEFAULT_TRIM:
            mhz = self.HSI_HZ // 1_000_000
            self.note("unmodelled", "CR.HSITRIM", f"is remembered; HSI stays at exactly {mhz} MHz")
        self[CR] = value
        self._hse.works = self._hse_healthy and self._bypass_fits()
        self._hsi.switch(bool(value & HSION))
        self._hse.switch(bool(value & HSEON))
        self._feed_pll()

    def _bypass_fits(self) -> bool:
        if not self[CR] & HSEBYP or self._hse_is_clock:
            return True
        self.note("misuse", "CR.HSEBYP", "the board has a crystal, not a clock, at OSC_IN: HSE will not become ready")
        return False

    def write_CIR(self, value: int) -> None:
        """Enables, and clears by writing 1; the clear bits read 0."""
        cleared = value >> 16 & 0xFF
        self[self.CIR] = value & 0xFFFF & ~cleared
        self._update_lines()

    def write_CSR(self, value: int) -> None:
        """LSION; RMVF clears the reset flags."""
        self[self.CSR] = value & ~self.RESET_FLAGS if value & RMVF else value
        self._lsi.switch(bool(value & LSION) or self._lsi_forced)

    # --- SYSCLK

    def _hse_drives(self, source: Source) -> bool:
        return source is Source.HSE or (source is Source.PLL and self._pll_runs_on_hse())

    def _needed_bits(self) -> int:
        """Return the bits of CR that hold up SYSCLK: of the source in use, and of the one selected."""
        needed = 0
        for source in (self._source, Source(self[self.CFGR] & SW)):
            needed |= HSEON if self._hse_drives(source) else HSION
            needed |= PLLON if source is Source.PLL else 0
        return needed

    def _on_ready(self, name: str, ready: bool) -> None:
        flag, offset, bit = self.READY[name]
        self[offset] = self[offset] | bit if ready else self[offset] & ~bit
        if ready and self[self.CIR] & flag << 8:
            self[self.CIR] |= flag
            self._update_lines()
        if name in ("HSI", "HSE"):
            self._feed_pll()
        if ready:
            self._try_switch()
        self._set_tree()

    def _feed_pll(self) -> None:
        entry = self._hse if self._pll_runs_on_hse() else self._hsi
        on = bool(self[CR] & PLLON) and entry.ready
        if on and not self._pll.on:
            self._check_pll()
        self._pll.switch(on)

    def _try_switch(self) -> None:
        wanted = Source(self[self.CFGR] & SW)
        oscillator = (self._hsi, self._hse, self._pll)[wanted]
        if oscillator.ready:
            self._source = wanted
            self[self.CFGR] = (self[self.CFGR] & ~0xC) | wanted << 2

    def _keep_source(self, value: int) -> int:
        """Return a value for CFGR with SW as it was if it is not allowed."""
        if value & SW != SW:
            return value
        self.note("misuse", "CFGR.SW", "11 is not allowed; SW keeps its value")
        return (value & ~SW) | (self[self.CFGR] & SW)

    # --- the clock security system

    def _is_guarded(self) -> bool:
        return bool(self[CR] & CSSON)

    def _runs_on_hse(self) -> bool:
        return self._hse_drives(self._source)

    def _on_failure(self) -> None:
        """The clock security system acts (RM0008 7.2.7, RM0410 5.2.7): off with the HSE, back to HSI, an NMI."""
        if self._hse_drives(self._source):
            if self._source is Source.PLL:
                self[CR] &= ~PLLON
            self._back_to_start()
        self[CR] &= ~HSEON
        self._hse.stop_now()
        self._feed_pll()
        self[self.CIR] |= CSSF
        self._update_lines()
        self._set_tree()
        self.on_clock_failure()

    def _update_lines(self) -> None:
        cir = self[self.CIR]
        self._irq.set(bool(cir & cir >> 8 & 0x7F))
        self.on_nmi(bool(cir & CSSF))
