"""RCC as far as all families have it in common: oscillators, gates, resets, the backup domain.

RM0008 section 7, RM0410 section 5, RM0433 section 8. The order at a reset of the chip: `BasicRcc.reset` first (the
clock is then HSI), FLASH second (the option bytes are loaded), then everybody else, then `BasicRcc.reset_by` with the
cause.

A peripheral is told of a change of its clock by `before_clock_change` and `after_clock_change`, and so it is when its
clock gate opens or shuts: `Peripheral.clocked` changes between the two calls. Choice where the manuals are silent: a
peripheral is reset at both edges of its bit in a reset register.
"""

from __future__ import annotations

import abc
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from types import MappingProxyType
from typing import ClassVar, Protocol, Required, TypedDict, Unpack

from targets.mcu.registers import Peripheral
from targets.mcu.services import Services
from targets.mcu.stm32.mco import Choice, ClockOutput
from targets.mcu.stm32.oscillator import Oscillator

__all__ = ["BDCR_BITS", "LSE_HZ", "LSION", "BackupPart", "BasicRcc", "BoardClocks", "ClockedPart"]

IRQ = 5

LSEON, LSERDY, LSEBYP, RTCSEL, RTCEN, BDRST = 1 << 0, 1 << 1, 1 << 2, 0x300, 1 << 15, 1 << 16
LSION, LSIRDY = 1 << 0, 1 << 1
BDCR_BITS = LSEON | LSEBYP | RTCSEL | RTCEN | BDRST
"""The bits of this register that can be written in every family."""
LSE_HZ = Fraction(32_768)
HSE_START_S = Fraction(2, 1000)


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


class BasicRcc(Peripheral, abc.ABC):
    """Reset and clock control; oscillators, gates, resets, the backup domain.

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
        BDCR, CSR: offsets of registers.
        FLAGS: offset of the register with the flags of resets; often CSR.
        ENABLE_OF: offset of the enable register of a bus.
        RESET_OF: the bus of a reset register, by its offset.
        HSI_HZ: rate of the internal high-speed oscillator.
        LSI_HZ: typical rate of the internal low-speed oscillator.
        LSE_START_S: typical time from LSEON to LSERDY.
        START_S: seconds from switching on to ready, by oscillator. Where a limit is all that is given, the slower one
            is taken. That of HSE and LSE is a matter of the board's crystals.
        CYCLES_TO_STOP: cycles of the oscillator from switching off to not ready.
        READY: by oscillator, its bit among the interrupt flags, and offset and bit of its ready flag.
        RESET_FLAGS: the flags that say what has caused the last resets.
        CAUSES: those that each cause sets.
        CLOCK_OUTPUTS: what CFGR chooses for each MCO.
        lsi_hz: rate of the internal low-speed oscillator, in hertz.
        on_nmi: called with the level of the NMI that the clock security system asks for.
        on_clock_failure: called when the clock security system finds the HSE dead; the break input of TIM1.
    """

    BDCR: ClassVar[int]
    CSR: ClassVar[int]
    FLAGS: ClassVar[int]
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
    CLOCK_OUTPUTS: ClassVar[tuple[Choice, ...]]

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
        self._outputs = tuple(ClockOutput(services, choice) for choice in self.CLOCK_OUTPUTS)
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
        self._hsi, self._hse, self._lse, self._lsi = (self._oscillators[name] for name in ("HSI", "HSE", "LSE", "LSI"))
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

    @property
    def starting(self) -> Mapping[str, Fraction]:
        """When the oscillators and PLLs that start will be ready, by name, in seconds of bench time."""
        ready = {name: oscillator.ready_s for name, oscillator in self._oscillators.items()}
        return {name: ready_s for name, ready_s in ready.items() if ready_s is not None}

    # --- what a family says

    @abc.abstractmethod
    def _set_tree(self, *, stopped: bool | None = None) -> None:
        """Make the clock tree what the registers say; `stopped` None for as it is."""

    @abc.abstractmethod
    def _rtc_hse_hz(self) -> Fraction:
        """Return the rate of the HSE as the RTC gets it, 0 for none."""

    @abc.abstractmethod
    def _on_ready(self, name: str, ready: bool) -> None:
        """An oscillator has become ready, or ceases to be."""

    @abc.abstractmethod
    def _update_lines(self) -> None:
        """Drive interrupt and NMI from flags and enables."""

    @abc.abstractmethod
    def _forget_source(self) -> None:
        """A reset: what SYSCLK runs on after it, and whatever else does not stand in a register."""

    @abc.abstractmethod
    def _stop_oscillators(self) -> None:
        """Let the oscillators stand still that Stop mode stops."""

    @abc.abstractmethod
    def _back_to_start(self) -> None:
        """Let SYSCLK run on what it does after Stop mode."""

    @abc.abstractmethod
    def _is_guarded(self) -> bool:
        """Say whether the clock security system watches the HSE."""

    @abc.abstractmethod
    def _runs_on_hse(self) -> bool:
        """Say whether SYSCLK comes from the HSE at present."""

    @abc.abstractmethod
    def _on_failure(self) -> None:
        """The clock security system acts."""

    @abc.abstractmethod
    def _bypass_fits(self) -> bool:
        """Say whether what HSEBYP says can work with what the board has at OSC_IN."""

    # --- resets

    def reset(self) -> None:
        """Go to the state after a reset of the chip: HSI, every gate shut. The backup domain and the flags stay."""
        kept = {self.BDCR: self[self.BDCR], self.FLAGS: self[self.FLAGS] & self.RESET_FLAGS}
        for name, oscillator in reversed(self._oscillators.items()):
            if name not in ("HSI", "LSE"):
                oscillator.stop_now()
        super().reset()
        for offset, value in kept.items():
            self[offset] = value
        self._lsi_forced = False
        self._forget_source()
        self._hse.works = self._hse_healthy
        self._hsi.run_now()
        self._set_tree(stopped=False)
        self._apply_gates()
        self._update_lines()

    def reset_by(self, cause: str) -> None:
        """Set the flags for a cause, as `services.chip_reset` names it; POR also resets the backup domain."""
        if cause in ("POR", "STANDBY"):
            self[self.FLAGS] &= ~self.RESET_FLAGS
        if cause == "POR":
            self[self.BDCR] = 0
            self._reset_backup_domain()
        self[self.FLAGS] |= self.CAUSES[cause]

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
        if self._is_guarded():
            self._on_failure()
        elif self._runs_on_hse():
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
        self._back_to_start()
        self._set_tree(stopped=True)

    def resume(self) -> None:
        """Leave Stop mode, on HSI."""
        self._set_tree(stopped=False)

    # --- registers

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

    # --- clocks

    def _tell_change(self, change: Callable[[], None]) -> None:
        """Make a change of the clock, with everybody told before and after."""
        for output in self._outputs:
            output.refresh()
        for part in self._parts:
            part.before_clock_change()
        change()
        for part in self._parts:
            part.after_clock_change()

    def _put_out(self, cfgr: int, clocks: Mapping[str, Fraction], *, stopped: bool) -> None:
        """Let the MCOs follow the clocks, by name; 0: it is not ready. In Stop mode only LSE and LSI run."""
        if stopped:
            clocks = {name: rate if name in ("LSE", "LSI") else Fraction(0) for name, rate in clocks.items()}
        for output in self._outputs:
            output.follow(cfgr, clocks)
