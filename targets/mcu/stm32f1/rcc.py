"""RCC: clocks and resets of the STM32F103 (RM0008 section 7), with oscillators that take their time to start.

The order at a reset of the chip: `Rcc.reset` first (the clock is then HSI), FLASH second (the option bytes are loaded),
then everybody else, then `Rcc.reset_by` with the cause.

A peripheral is told of a change of its clock by `before_clock_change` and `after_clock_change`, and so it is when its
clock gate opens or shuts: `Peripheral.clocked` changes between the two calls.

Choices where the manual is silent: SYSCLK switches at once when the wanted source is ready; SW = 11 is not taken over;
a peripheral is reset at both edges of its bit in APBxRSTR.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from typing import ClassVar, Protocol

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.stm32f1.clock_limits import violations
from targets.mcu.stm32f1.clocks import ClockTree, Source, pll_hz, rates_of
from targets.mcu.stm32f1.oscillator import Oscillator

__all__ = ["BackupPart", "ClockedPart", "Rcc"]

IRQ = 5

CR, CFGR, CIR, APB2RSTR, APB1RSTR, AHBENR, APB2ENR, APB1ENR, BDCR, CSR = range(0, 0x28, 4)

HSION, HSIRDY, HSEON, HSERDY, HSEBYP, CSSON = 1 << 0, 1 << 1, 1 << 16, 1 << 17, 1 << 18, 1 << 19
PLLON, PLLRDY = 1 << 24, 1 << 25
SW, PLLSRC, PLL_SETTINGS = 0x3, 1 << 16, 0x3F << 16
LSEON, LSERDY, LSEBYP, RTCSEL, RTCEN, BDRST = 1 << 0, 1 << 1, 1 << 2, 0x300, 1 << 15, 1 << 16
LSION, LSIRDY, RMVF, RESET_FLAGS = 1 << 0, 1 << 1, 1 << 24, 0xFC00_0000
CSSF = 1 << 7
DEFAULT_TRIM = 0x10

# Start-up: DS5319, tables of the HSI (1 to 2 us), LSI (at most 85 us) and PLL (lock time at most 200 us). Where a limit
# is all that is given, the slower one is taken. That of HSE and LSE is a matter of the board's crystals.
START_S = {
    "HSI": Fraction(2, 1_000_000),
    "LSI": Fraction(85, 1_000_000),
    "PLL": Fraction(200, 1_000_000),
}
# After xxxON is cleared, xxxRDY goes low after so many cycles of the oscillator (RM0008 sections 7.3.1, 7.3.9, 7.3.10).
CYCLES_TO_STOP = {"HSI": 6, "HSE": 6, "LSE": 6, "LSI": 3}

# Bits of RCC_CIR and where the ready bit lives, by oscillator.
READY = {
    "LSI": (1 << 0, CSR, LSIRDY),
    "LSE": (1 << 1, BDCR, LSERDY),
    "HSI": (1 << 2, CR, HSIRDY),
    "HSE": (1 << 3, CR, HSERDY),
    "PLL": (1 << 4, CR, PLLRDY),
}
# Every reset of the chip also pulls NRST low, so that PINRSTF comes with each (RM0008 section 7.1.1, figure 7). Leaving
# Standby is a power reset (section 7.1.2).
CAUSES = {
    "PIN": 1 << 26,
    "POR": 3 << 26,
    "STANDBY": 3 << 26,
    "SFT": 5 << 26,
    "IWDG": 9 << 26,
    "WWDG": 17 << 26,
    "LPWR": 33 << 26,
}

ENABLE_OF = {"AHB": AHBENR, "APB2": APB2ENR, "APB1": APB1ENR}
RESET_OF = {APB2RSTR: "APB2", APB1RSTR: "APB1"}
ADCS, USB = 3 << 9, 1 << 23
APB1_BITS = 0x1AE6_4807  # TIM2-4, WWDG, SPI2, USART2-3, I2C1-2, USB, CAN, BKP, PWR
APB2_BITS = 0x0000_5E7D  # AFIO, GPIOA-E, ADC1-2, TIM1, SPI1, USART1
AHB_BITS = 0x0000_0055  # DMA1, SRAM, FLITF, CRC


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


class Rcc(Peripheral):
    """Reset and clock control.

    Args:
        base: address of its first register.
        services: what the chip offers.
        tree: the clock tree this sets; it is also the chip's `services.clocks`.
        hse_hz: crystal or clock at OSC_IN; None if the board has neither.
        hse_is_clock: the board drives OSC_IN with a clock; HSEBYP works only then.
        hse_start_s: from HSEON to HSERDY; DS5319: typically 2 ms.
        lse: the board has a crystal of 32.768 kHz.
        lse_start_s: from LSEON to LSERDY; DS5319: typically 2.5 s at 25 degrees.
        lsi_hz: rate of the internal low-speed oscillator.
        backup_writable: says whether PWR_CR.DBP opens the backup domain.

    Attributes:
        lsi_hz: rate of the internal low-speed oscillator, in hertz.
        on_nmi: called with the level of the NMI that the clock security system asks for.
        on_clock_failure: called when the clock security system finds the HSE dead; the break input of TIM1.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("CR", CR, 0x0000_0083, HSION | 0xF8 | HSEON | HSEBYP | CSSON | PLLON, note="HSICAL reads 0 (choice)"),
        Register("CFGR", CFGR, 0, 0x077F_FFF3, fidelity=Fidelity.PARTLY, note="MCO: the pin carries no edges"),
        Register("CIR", CIR, 0, 0x009F_1F00),
        Register("APB2RSTR", APB2RSTR, 0, APB2_BITS),
        Register("APB1RSTR", APB1RSTR, 0, APB1_BITS),
        Register("AHBENR", AHBENR, 0x14, AHB_BITS, fidelity=Fidelity.PARTLY, note="SRAM, FLITF: gates are remembered"),
        Register("APB2ENR", APB2ENR, 0, APB2_BITS),
        Register("APB1ENR", APB1ENR, 0, APB1_BITS),
        Register("BDCR", BDCR, 0, LSEON | LSEBYP | RTCSEL | RTCEN | BDRST),
        Register("CSR", CSR, CAUSES["POR"], LSION | RMVF),
    )

    def __init__(
        self,
        base: int,
        services: Services,
        tree: ClockTree,
        *,
        hse_hz: int | Fraction | None,
        hse_is_clock: bool = False,
        hse_start_s: Fraction = Fraction(2, 1000),
        lse: bool = True,
        lse_start_s: Fraction = Fraction(5, 2),
        lsi_hz: int | Fraction = 40_000,
        backup_writable: Callable[[], bool],
    ) -> None:
        super().__init__("RCC", base, services)
        self.tree = tree
        self.hse_hz = Fraction(hse_hz or 0)
        self.lsi_hz = Fraction(lsi_hz)
        self.on_nmi: Callable[[bool], None] = lambda _level: None
        self.on_clock_failure: Callable[[], None] = lambda: None
        self._hse_is_clock = hse_is_clock
        self._hse_healthy = hse_hz is not None
        self._backup_writable = backup_writable
        self._irq = services.irq(IRQ)
        self._mco = services.output("MCO")
        self._source = Source.HSI
        self._lsi_forced = False
        self._gated: list[tuple[Peripheral, int, int]] = []
        self._resettable: list[tuple[Peripheral, str, int]] = []
        self._parts: list[ClockedPart] = []
        self._backup: list[BackupPart] = []
        rates = {"HSI": Fraction(8_000_000), "HSE": self.hse_hz, "LSE": Fraction(32_768), "LSI": self.lsi_hz}
        starts = START_S | {"HSE": hse_start_s, "LSE": lse_start_s}
        self._hsi, self._hse, self._lse, self._lsi, self._pll = (
            self._oscillator(name, starts[name], rates.get(name)) for name in ("HSI", "HSE", "LSE", "LSI", "PLL")
        )
        self._hse.works = self._hse_healthy
        self._lse.works = lse
        self._hsi.run_now()

    def _oscillator(self, name: str, start_s: Fraction, rate: Fraction | None) -> Oscillator:
        stop_s = CYCLES_TO_STOP[name] / rate if rate else Fraction(0)
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
            gates: by name of the peripheral, the bus (``AHB``, ``APB1``, ``APB2``) and the bit in its enable and reset
                registers. Several peripherals may share a bit. Names without a peripheral are allowed.
            peripherals: every peripheral of the chip by its name.
            others: what also counts cycles, such as the SysTick timer.
            backup: what a reset of the backup domain resets.
        """
        self._parts = [part for part in peripherals.values() if part is not self] + list(others)
        self._backup = list(backup)
        for name, (bus, bit) in gates.items():
            if name in peripherals:
                self._gated.append((peripherals[name], ENABLE_OF[bus], 1 << bit))
                self._resettable.append((peripherals[name], bus, 1 << bit))
        self._apply_gates()

    # --- resets

    def reset(self) -> None:
        """Go to the state after a reset of the chip: HSI, every gate shut. The backup domain and the flags stay."""
        kept = {BDCR: self[BDCR], CSR: self[CSR] & RESET_FLAGS}
        for oscillator in (self._pll, self._hse, self._lsi):
            oscillator.stop_now()
        super().reset()
        self[BDCR], self[CSR] = kept[BDCR], kept[CSR]
        self._lsi_forced = False
        self._source = Source.HSI
        self._hse.works = self._hse_healthy
        self._hsi.run_now()
        self._update(stopped=False)
        self._apply_gates()
        self._update_lines()

    def reset_by(self, cause: str) -> None:
        """Set the flags of CSR for a cause, as `services.chip_reset` names it; POR also resets the backup domain."""
        if cause in ("POR", "STANDBY"):
            self[CSR] &= ~RESET_FLAGS
        if cause == "POR":
            self[BDCR] = 0
            self._reset_backup_domain()
        self[CSR] |= CAUSES[cause]

    def _reset_backup_domain(self) -> None:
        self[BDCR] &= BDRST
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
        if not self[BDCR] & RTCEN:
            return None
        sources = {
            0x100: (self._lse, Fraction(32_768)),
            0x200: (self._lsi, self.lsi_hz),
            0x300: (self._hse, self.hse_hz / 128),
        }
        oscillator, rate = sources.get(self[BDCR] & RTCSEL, (None, None))
        return rate if oscillator is not None and oscillator.ready else None

    def stop(self) -> None:
        """Enter Stop mode: all but LSE and LSI stands still (RM0008 section 4.3.4). Cycles still count, as of HSI."""
        self[CR] &= ~(HSEON | PLLON)
        self._pll.stop_now()
        self._hse.stop_now()
        self._back_to_hsi()
        self._update(stopped=True)

    def resume(self) -> None:
        """Leave Stop mode, on HSI."""
        self._update(stopped=False)

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
            self.note("unmodelled", "CR.HSITRIM", "is remembered; HSI stays at exactly 8 MHz")
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

    def write_CFGR(self, value: int) -> None:
        """Prescalers at once; SYSCLK when the source is ready; the PLL only while it is off."""
        old = self[CFGR]
        if self[CR] & PLLON and (value ^ old) & PLL_SETTINGS:
            self.note("misuse", "CFGR.PLLMUL", "the PLL is on: PLLSRC, PLLXTPRE and PLLMUL keep their values")
            value = (value & ~PLL_SETTINGS) | (old & PLL_SETTINGS)
        if value & SW == SW:
            self.note("misuse", "CFGR.SW", "11 is not allowed; SW keeps its value")
            value = (value & ~SW) | (old & SW)
        self[CFGR] = value
        self._try_switch()
        self._update()

    def write_CIR(self, value: int) -> None:
        """Enables, and clears by writing 1; the clear bits read 0."""
        cleared = value >> 16 & 0x9F
        self[CIR] = value & 0x1F9F & ~cleared
        self._update_lines()

    def write_APB2RSTR(self, value: int) -> None:
        """Reset the peripherals of APB2."""
        self._write_resets(APB2RSTR, value)

    def write_APB1RSTR(self, value: int) -> None:
        """Reset the peripherals of APB1."""
        self._write_resets(APB1RSTR, value)

    def write_AHBENR(self, value: int) -> None:
        """Open and shut clock gates."""
        self._write_gates(AHBENR, value)

    def write_APB2ENR(self, value: int) -> None:
        """Open and shut clock gates."""
        self._write_gates(APB2ENR, value)

    def write_APB1ENR(self, value: int) -> None:
        """Open and shut clock gates."""
        self._write_gates(APB1ENR, value)

    def write_BDCR(self, value: int) -> None:
        """LSE and the clock of the RTC; all but BDRST obey PWR_CR.DBP (RM0008 section 7.3.9)."""
        old = self[BDCR]
        if not self._backup_writable():
            if (value ^ old) & ~BDRST:
                self.note("misuse", "BDCR", "the backup domain is write-protected: PWR_CR.DBP is not set")
            value = (old & ~BDRST) | (value & BDRST)
        if value & BDRST:
            self[BDCR] = BDRST
            self._reset_backup_domain()
            return
        if old & RTCSEL and (value ^ old) & RTCSEL:
            self.note("misuse", "BDCR.RTCSEL", "is chosen once; only a reset of the backup domain frees it")
            value = (value & ~RTCSEL) | (old & RTCSEL)
        if old & LSEON:
            value = (value & ~LSEBYP) | (old & LSEBYP)
        self[BDCR] = value
        self._lse.switch(bool(value & LSEON))

    def write_CSR(self, value: int) -> None:
        """LSION; RMVF clears the reset flags."""
        self[CSR] = value & ~RESET_FLAGS if value & RMVF else value
        self._lsi.switch(bool(value & LSION) or self._lsi_forced)

    def write(self, offset: int, value: int) -> None:
        """As of every peripheral; a gate that this chip does not have is noted."""
        if offset in (AHBENR, APB2ENR, APB1ENR) and value & ~self.registers[offset].writable:
            name, bits = self.registers[offset].name, value & ~self.registers[offset].writable
            self.note("reserved", name, f"bits 0x{bits:X} enable what this chip does not have")
        super().write(offset, value)

    # --- gates and resets of peripherals

    def _write_gates(self, offset: int, value: int) -> None:
        self[offset] = value
        self._apply_gates()
        self._check_rates()

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
            if bus == RESET_OF[offset] and changed & bit:
                peripheral.reset()

    # --- SYSCLK

    def _hse_drives(self, source: Source) -> bool:
        return source is Source.HSE or (source is Source.PLL and bool(self[CFGR] & PLLSRC))

    def _needed_bits(self) -> int:
        """Return the bits of CR that hold up SYSCLK: of the source in use, and of the one selected."""
        needed = 0
        for source in (self._source, Source(self[CFGR] & SW)):
            needed |= HSEON if self._hse_drives(source) else HSION
            needed |= PLLON if source is Source.PLL else 0
        return needed

    def _on_ready(self, name: str, ready: bool) -> None:
        flag, offset, bit = READY[name]
        self[offset] = self[offset] | bit if ready else self[offset] & ~bit
        if ready and self[CIR] & flag << 8:
            self[CIR] |= flag
            self._update_lines()
        if name in ("HSI", "HSE"):
            self._feed_pll()
        if ready:
            self._try_switch()
            self._update()

    def _feed_pll(self) -> None:
        entry = self._hse if self[CFGR] & PLLSRC else self._hsi
        on = bool(self[CR] & PLLON) and entry.ready
        if on and not self._pll.on:
            self._check_pll()
        self._pll.switch(on)

    def _check_pll(self) -> None:
        mhz = pll_hz(self[CFGR], self.hse_hz) / 1_000_000
        if not 16 <= mhz <= 72:  # DS5319, PLL characteristics
            self.note("misuse", "CFGR.PLLMUL", f"the PLL makes 16 to 72 MHz, not {float(mhz):g} MHz")

    def _try_switch(self) -> None:
        wanted = Source(self[CFGR] & SW)
        oscillator = (self._hsi, self._hse, self._pll)[wanted]
        if oscillator.ready:
            self._source = wanted
            self[CFGR] = (self[CFGR] & ~0xC) | wanted << 2

    def _back_to_hsi(self) -> None:
        self[CR] |= HSION
        self[CFGR] &= ~0xF
        self._hsi.run_now()
        self._source = Source.HSI

    def _on_failure(self) -> None:
        """The clock security system acts (RM0008 section 7.2.7): off with the HSE, back to HSI, an NMI."""
        if self._hse_drives(self._source):
            if self._source is Source.PLL:
                self[CR] &= ~PLLON
            self._back_to_hsi()
        self[CR] &= ~HSEON
        self._hse.stop_now()
        self._feed_pll()
        self[CIR] |= CSSF
        self._update_lines()
        self._update()
        self.on_clock_failure()

    def _update_lines(self) -> None:
        cir = self[CIR]
        self._irq.set(bool(cir & cir >> 8 & 0x1F))
        self.on_nmi(bool(cir & CSSF))

    def _update(self, *, stopped: bool | None = None) -> None:
        """Make the tree what the registers say; everybody is told before and after."""
        tree = self.tree
        rates = rates_of(self[CFGR], self._source, self.hse_hz)
        halted = tree.stopped if stopped is None else stopped
        self._mco.set(False if self[CFGR] & 1 << 26 else None)
        if rates == tree.rates and halted is tree.stopped:
            return
        for part in self._parts:
            part.before_clock_change()
        tree.set(rates, stopped=halted)
        if rates.hclk != self.time.hclk_hz:
            self.time.set_hclk(rates.hclk)
        for part in self._parts:
            part.after_clock_change()
        self._check_rates()

    def _check_rates(self) -> None:
        usb_on = bool(self[APB1ENR] & USB)
        for where, text in violations(self.tree.rates, adc_on=bool(self[APB2ENR] & ADCS), usb_on=usb_on):
            self.note("misuse", where, text)
