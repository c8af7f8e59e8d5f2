"""RCC as far as the F1 and the F7 have it in common: oscillators, SYSCLK, gates, resets (RM0008 section 7, RM0410 5).

The order at a reset of the chip: `BasicRcc.reset` first (the clock is then HSI), FLASH second (the option bytes are
loaded), then everybody else, then `BasicRcc.reset_by` with the cause.

A peripheral is told of a change of its clock by `before_clock_change` and `after_clock_change`, and so it is when its
clock gate opens or shuts: `Peripheral.clocked` changes between the two calls.

Choices where the manuals are silent: SYSCLK switches at once when the wanted source is ready; SW = 11 is not taken
over; a peripheral is reset at both edges of its bit in a reset register.
"""

from __future__ import annotations

import abc
import enum
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from types import MappingProxyType
from typing import ClassVar, Protocol, Required, TypedDict, Unpack

from targets.mcu.registers import Peripheral
from targets.mcu.services import Services
from targets.mcu.stm32.oscillator import Oscillator

__all__ = [
    "BDCR_BITS",
    "CR_BITS",
    "CSR_BITS",
    "BackupPart",
    "BasicRcc",
    "BoardClocks",
    "ClockedPart",
    "Source",
    "ready_bits",
]

IRQ = 5

CR = 0x00
HSION, HSIRDY, HSEON, HSERDY, HSEBYP, CSSON = 1 << 0, 1 << 1, 1 << 16, 1 << 17, 1 << 18, 1 << 19
PLLON, PLLRDY = 1 << 24, 1 << 25
SW = 0x3
LSEON, LSERDY, LSEBYP, RTCSEL, RTCEN, BDRST = 1 << 0, 1 << 1, 1 << 2, 0x300, 1 << 15, 1 << 16
LSION, LSIRDY, RMVF = 1 << 0, 1 << 1, 1 << 24
CSSF = 1 << 7
CR_BITS = HSION | 0xF8 | HSEON | HSEBYP | CSSON | PLLON
BDCR_BITS = LSEON | LSEBYP | RTCSEL | RTCEN | BDRST
CSR_BITS = LSION | RMVF
"""The bits of these registers that can be written in every family."""
DEFAULT_TRIM = 0x10
LSE_HZ = Fraction(32_768)
HSE_START_S = Fraction(2, 1000)


class Source(enum.IntEnum):
    """What drives SYSCLK; the values of CFGR.SW and SWS."""

    HSI = 0
    HSE = 1
    PLL = 2


class ClockedPart(Protocol):
    """Whatever counts cycles of a derived clock."""

    def before_clock_change(self) -> None:
        """Bring everything up to the present cycle."""

    def after_clock_change(self) -> None:
        """Enter the events anew."""


class BackupPart(Protocol):
    """What lives in the backup domain."""

    def reset_backup(self) -> None:
        """Go to the state after a reset of the backup domain."""


class BoardClocks(TypedDict, total=False):
    """What the board has to do with the clocks; see `BasicRcc`."""

    hse_hz: Required[int | Fraction | None]
    hse_is_clock: bool
    hse_start_s: Fraction
    lse: bool
    lse_start_s: Fraction
    lsi_hz: int | Fraction
    backup_writable: Required[Callable[[], bool]]


def ready_bits(bdcr: int, csr: int) -> dict[str, tuple[int, int, int]]:
    """Return what every family has of `BasicRcc.READY`, by the offsets of BDCR and CSR."""
    return {
        "LSI": (1 << 0, csr, LSIRDY),
        "LSE": (1 << 1, bdcr, LSERDY),
        "HSI": (1 << 2, CR, HSIRDY),
        "HSE": (1 << 3, CR, HSERDY),
        "PLL": (1 << 4, CR, PLLRDY),
    }


class BasicRcc(Peripheral):
    """Reset and clock control; a family says where its registers are and what the rates of its clocks are.

    Args:
        base: address of its first register.
        services: what the chip offers.
        hse_hz: crystal or clock at OSC_IN; None if the board has neither.
        hse_is_clock: the board drives OSC_IN with a clock; HSEBYP works only then.
        hse_start_s: from HSEON to HSERDY; typically 2 ms for a crystal (DS5319, DS11532).
        lse: the board has a crystal of 32.768 kHz.
        lse_start_s: from LSEON to LSERDY; `LSE_START_S` if not given.
        lsi_hz: rate of the internal low-speed oscillator; `LSI_HZ` if not given.
        backup_writable: says whether PWR_CR.DBP opens the backup domain.

    Attributes:
        CFGR, CIR, BDCR, CSR: offsets of registers.
        ENABLE_OF: offset of the enable register of a bus.
        RESET_OF: the bus of a reset register, by its offset.
        HSI_HZ: rate of the internal high-speed oscillator.
        LSI_HZ: typical rate of the internal low-speed oscillator.
        LSE_START_S: typical time from LSEON to LSERDY.
        START_S: seconds from switching on to ready, by oscillator. Where a limit is all that is given, the slower one
            is taken. That of HSE and LSE is a matter of the board's crystals.
        CYCLES_TO_STOP: cycles of the oscillator from switching off to not ready.
        READY: by oscillator, its bit in CIR, and offset and bit of its ready flag.
        RESET_FLAGS: the flags of CSR that say what has caused the last resets.
        CAUSES: those that each cause sets.
        lsi_hz: rate of the internal low-speed oscillator, in hertz.
        on_nmi: called with the level of the NMI that the clock security system asks for.
        on_clock_failure: called when the clock security system finds the HSE dead; the break input of TIM1.
    """

    CFGR: ClassVar[int]
    CIR: ClassVar[int]
    BDCR: ClassVar[int]
    CSR: ClassVar[int]
    ENABLE_OF: ClassVar[Mapping[str, int]]
    RESET_OF: ClassVar[Mapping[int, str]]
    HSI_HZ: ClassVar[Fraction]
    LSI_HZ: ClassVar[Fraction]
    LSE_START_S: ClassVar[Fraction]
    START_S: ClassVar[Mapping[str, Fraction]]
    CYCLES_TO_STOP: ClassVar[Mapping[str, int]] = MappingProxyType({"HSI": 6, "HSE": 6, "LSE": 6, "LSI": 3})
    READY: ClassVar[Mapping[str, tuple[int, int, int]]]
    RESET_FLAGS: ClassVar[int]
    CAUSES: ClassVar[Mapping[str, int]]

    def __init__(self, base: int, services: Services, **board: Unpack[BoardClocks]) -> None:
        super().__init__("RCC", base, services)
        self.hse_hz = Fraction(board["hse_hz"] or 0)
        self.lsi_hz = Fraction(board.get("lsi_hz", self.LSI_HZ))
        self.on_nmi: Callable[[bool], None] = lambda _level: None
        self.on_clock_failure: Callable[[], None] = lambda: None
        self._hse_is_clock = board.get("hse_is_clock", False)
        self._hse_healthy = board["hse_hz"] is not None
        self._backup_writable = board["backup_writable"]
        self._irq = services.irq(IRQ)
        self._source = Source.HSI
        self._lsi_forced = False
        self._gated: list[tuple[Peripheral, int, int]] = []
        self._resettable: list[tuple[Peripheral, str, int]] = []
        self._parts: list[ClockedPart] = []
        self._backup: list[BackupPart] = []
        rates = {"HSI": self.HSI_HZ, "HSE": self.hse_hz, "LSE": LSE_HZ, "LSI": self.lsi_hz}
        starts = {
            **self.START_S,
            "HSE": board.get("hse_start_s", HSE_START_S),
            "LSE": board.get("lse_start_s", self.LSE_START_S),
        }
        self._oscillators = {name: self._oscillator(name, starts[name], rates.get(name)) for name in self.READY}
        self._hsi, self._hse, self._lse, self._lsi, self._pll = (
            self._oscillators[name] for name in ("HSI", "HSE", "LSE", "LSI", "PLL")
        )
        self._hse.works = self._hse_healthy
        self._lse.works = board.get("lse", True)
        self._hsi.run_now()

    def _oscillator(self, name: str, start_s: Fraction, rate: Fraction | None) -> Oscillator:
        stop_s = self.CYCLES_TO_STOP[name] / rate if rate else Fraction(0)
        return Oscillator(self.time, start_s, stop_s, lambda ready: self._on_ready(name, ready))

    def connect(
        self,
        gates: Mapping[str, tuple[str, int]],
        peripherals: Mapping[str, Peripheral],
        *,
        others: Iterable[ClockedPart] = (),
        backup: Iterable[BackupPart] = (),
    ) -> None:
        """Tell which peripheral hangs on which bit, and who else is told of changes of the clock.

        Args:
            gates: by name of the peripheral, the bus (such as ``APB1``) and the bit in its enable and reset registers.
                Several peripherals may share a bit. Names without a peripheral are allowed.
            peripherals: every peripheral of the chip by its name.
            others: what also counts cycles, such as the SysTick timer.
            backup: what a reset of the backup domain resets.
        """
        self._parts = [part for part in peripherals.values() if part is not self] + list(others)
        self._backup = list(backup)
        for name, (bus, bit) in gates.items():
            if name in peripherals:
                self._gated.append((peripherals[name], self.ENABLE_OF[bus], 1 << bit))
                self._resettable.append((peripherals[name], bus, 1 << bit))
        self._apply_gates()

    # --- what a family says

    @abc.abstractmethod
    def _pll_runs_on_hse(self) -> bool:
        """Say whether the HSE is selected as the source of the PLL."""

    @abc.abstractmethod
    def _check_pll(self) -> None:
        """Note what is wrong with the settings of the PLL, which is about to start."""

    @abc.abstractmethod
    def _set_tree(self, *, stopped: bool | None = None) -> None:
        """Make the clock tree what the registers say; `stopped` None for as it is."""

    @abc.abstractmethod
    def _rtc_hse_hz(self) -> Fraction:
        """Return the rate of the HSE as the RTC gets it, 0 for none."""

    # --- resets

    def reset(self) -> None:
        """Go to the state after a reset of the chip: HSI, every gate shut. The backup domain and the flags stay."""
        kept = {self.BDCR: self[self.BDCR], self.CSR: self[self.CSR] & self.RESET_FLAGS}
        for name, oscillator in reversed(self._oscillators.items()):
            if name not in ("HSI", "LSE"):
                oscillator.stop_now()
        super().reset()
        for offset, value in kept.items():
            self[offset] = value
        self._lsi_forced = False
        self._source = Source.HSI
        self._hse.works = self._hse_healthy
        self._hsi.run_now()
        self._set_tree(stopped=False)
        self._apply_gates()
        self._update_lines()

    def reset_by(self, cause: str) -> None:
        """Set the flags of CSR for a cause, as `services.chip_reset` names it; POR also resets the backup domain."""
        if cause in ("POR", "STANDBY"):
            self[self.CSR] &= ~self.RESET_FLAGS
        if cause == "POR":
            self[self.BDCR] = 0
            self._reset_backup_domain()
        self[self.CSR] |= self.CAUSES[cause]

    def _reset_backup_domain(self) -> None:
        self[self.BDCR] &= BDRST
        self._lse.stop_now()
        for part in self._backup:
            part.reset_backup()

    # --- what the board and the rest of the chip may do

    def fail_hse(self) -> None:
        """The crystal of the HSE breaks."""
        was_ready = self._hse.ready
        self._hse_healthy = False
        self._hse.fail()
        if not was_ready:
            return
        if self[CR] & CSSON:
            self._on_failure()
        elif self._hse_drives(self._source):
            self.note("unmodelled", "CR.CSSON", "the HSE failed unguarded: silicon stands still, the model runs on")

    def repair_hse(self) -> None:
        """The crystal of the HSE works (again)."""
        self._hse_healthy = True
        if self._bypass_fits():
            self._hse.repair()

    def force_lsi(self) -> None:
        """The independent watchdog runs: the LSI is on and stays on until the next reset (RM0008 section 7.2.5)."""
        self._lsi_forced = True
        self._lsi.switch(True)

    def lsi_on(self) -> bool:
        """Say whether the LSI is switched on."""
        return self._lsi.on

    def hsi_on(self) -> bool:
        """Say whether the HSI is ready; programming the flash needs it."""
        return self._hsi.ready

    def rtc_hz(self) -> Fraction | None:
        """Return the rate of RTCCLK, or None while BDCR selects none or the one selected does not run."""
        if not self[self.BDCR] & RTCEN:
            return None
        choice = self[self.BDCR] & RTCSEL
        if choice == 0x100:
            return LSE_HZ if self._lse.ready else None
        if choice == 0x200:
            return self.lsi_hz if self._lsi.ready else None
        return (self._rtc_hse_hz() or None) if choice == 0x300 and self._hse.ready else None

    def stop(self) -> None:
        """Enter Stop mode: all but LSE and LSI stands still (RM0008 section 4.3.4). Cycles still count, as of HSI."""
        self._stop_oscillators()
        self._back_to_hsi()
        self._set_tree(stopped=True)

    def resume(self) -> None:
        """Leave Stop mode, on HSI."""
        self._set_tree(stopped=False)

    def _stop_oscillators(self) -> None:
        self[CR] &= ~(HSEON | PLLON)
        self._pll.stop_now()
        self._hse.stop_now()

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

    def write_BDCR(self, value: int) -> None:
        """LSE and the clock of the RTC; all but BDRST obey PWR_CR.DBP (RM0008 section 7.3.9, RM0410 5.3.20)."""
        old = self[self.BDCR]
        if not self._backup_writable():
            if (value ^ old) & ~BDRST:
                self.note("misuse", "BDCR", "the backup domain is write-protected: PWR_CR.DBP is not set")
            value = (old & ~BDRST) | (value & BDRST)
        if value & BDRST:
            self[self.BDCR] = BDRST
            self._reset_backup_domain()
            return
        if old & RTCSEL and (value ^ old) & RTCSEL:
            self.note("misuse", "BDCR.RTCSEL", "is chosen once; only a reset of the backup domain frees it")
            value = (value & ~RTCSEL) | (old & RTCSEL)
        if old & LSEON:
            value = (value & ~LSEBYP) | (old & LSEBYP)
        self[self.BDCR] = value
        self._lse.switch(bool(value & LSEON))

    def write_CSR(self, value: int) -> None:
        """LSION; RMVF clears the reset flags."""
        self[self.CSR] = value & ~self.RESET_FLAGS if value & RMVF else value
        self._lsi.switch(bool(value & LSION) or self._lsi_forced)

    def write(self, offset: int, value: int) -> None:
        """As of every peripheral; a gate that this chip does not have is noted."""
        if offset in self.ENABLE_OF.values() and value & ~self.registers[offset].writable:
            name, bits = self.registers[offset].name, value & ~self.registers[offset].writable
            self.note("reserved", name, f"bits 0x{bits:X} enable what this chip does not have")
        super().write(offset, value)

    # --- gates and resets of peripherals

    def _write_gates(self, offset: int, value: int) -> None:
        self[offset] = value
        self._apply_gates()

    def _apply_gates(self) -> None:
        for peripheral, offset, bit in self._gated:
            clocked = bool(self[offset] & bit)
            if clocked is not peripheral.clocked:
                peripheral.before_clock_change()
                peripheral.clocked = clocked
                peripheral.after_clock_change()

    def _write_resets(self, offset: int, value: int) -> None:
        changed = value ^ self[offset]
        self[offset] = value
        for peripheral, bus, bit in self._resettable:
            if bus == self.RESET_OF[offset] and changed & bit:
                peripheral.reset()

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

    def _back_to_hsi(self) -> None:
        self[CR] |= HSION
        self[self.CFGR] &= ~0xF
        self._hsi.run_now()
        self._source = Source.HSI

    def _on_failure(self) -> None:
        """The clock security system acts (RM0008 7.2.7, RM0410 5.2.7): off with the HSE, back to HSI, an NMI."""
        if self._hse_drives(self._source):
            if self._source is Source.PLL:
                self[CR] &= ~PLLON
            self._back_to_hsi()
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

    def _tell_change(self, change: Callable[[], None]) -> None:
        """Make a change of the clock, with everybody told before and after."""
        for part in self._parts:
            part.before_clock_change()
        change()
        for part in self._parts:
            part.after_clock_change()
