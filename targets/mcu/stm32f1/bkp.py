"""BKP: half-words that survive everything but power-off and tampering, and what the RTC puts out (RM0008 section 6).

Choices where the manual is silent: the pulse of an alarm or a second is high; RTCCLK / 64 is that before its
calibration, begins low, and goes before the pulses if both are chosen.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction
from typing import ClassVar

from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.stm32.mco import Choice, ClockOutput
from targets.mcu.stm32f1.densities import MEDIUM, Density
from targets.mcu.stm32f1.rtc import ALRF, SECF

__all__ = ["Bkp"]

TAMPER_IRQ = 2
DATA = (*range(0x04, 0x2C, 4), *range(0x40, 0xC0, 4))  # DR1 to DR10, DR11 to DR42
RTCCR, CR, CSR = 0x2C, 0x30, 0x34
CCO, ASOE, ASOS = 1 << 7, 1 << 8, 1 << 9  # of RTCCR
TPE, TPAL = 1 << 0, 1 << 1
_CLOCK = Choice(name="TAMPER", shift=7, clocks=(None, "RTCCLK"), dividers=(64,))
CTE, CTI, TPIE, TEF, TIF = 1 << 0, 1 << 1, 1 << 2, 1 << 8, 1 << 9


class Bkp(Peripheral):
    """Backup registers and tamper detection.

    Args:
        base: address of its first register.
        services: what the chip offers; the pin is its input ``TAMPER``, asked for when TPE is set, and its output.
        backup_writable: says whether PWR_CR.DBP opens the backup domain; without it writes are lost.
        density: says how many half-words there are.
        rtc_hz: returns the rate of RTCCLK, None while it stands still.

    Attributes:
        on_calibration: called when `rtc_calibration` may have changed.
        on_output: called with whether the RTC has the pin as an output, and which of its flags it tells there
            (`Rtc.tell`), after a change.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("RTCCR", RTCCR, 0, 0x3FF),
        Register("CR", CR, 0, TPE | TPAL),
        Register("CSR", CSR, 0, CTE | CTI | TPIE),
    )

    def __init__(
        self,
        base: int,
        services: Services,
        *,
        backup_writable: Callable[[], bool],
        density: Density = MEDIUM,
        rtc_hz: Callable[[], Fraction | None] = lambda: None,
    ) -> None:
        self._data = DATA[: density.backup_registers]
        super().__init__("BKP", base, services)
        self._writable = backup_writable
        self.on_calibration: Callable[[], None] = lambda: None
        self._irq = services.irq(TAMPER_IRQ)
        self._tamper = services.input("TAMPER")
        self._rtc_hz = rtc_hz
        self._clock = ClockOutput(services, _CLOCK)
        self._out = services.output("TAMPER")
        self._puts_out = 0  # CCO, ASOE and ASOS as obeyed
        self.on_output: Callable[[bool, int], None] = lambda _on, _flag: None

    def registers_of(self) -> Iterable[Register]:
        """Return the half-words of this density, and the rest."""
        return (*(Register(f"DR{n}", offset, 0, 0xFFFF) for n, offset in enumerate(self._data, 1)), *self.REGISTERS)

    def reset(self) -> None:
        """A reset of the chip reaches TPIE and the flag of the interrupt only."""
        self[CSR] &= ~(TPIE | TIF)
        self._irq.set(False)

    def reset_backup(self) -> None:
        """A reset of the backup domain clears everything."""
        super().reset()
        self._irq.set(False)
        self._put_out()

    def before_clock_change(self) -> None:
        """Tell the edges so far, whose cycles are counted anew."""
        self._clock.refresh()

    def write(self, offset: int, value: int) -> None:
        """As of every peripheral, if the backup domain is open."""
        if self._writable():
            super().write(offset, value)
        else:
            self.note("misuse", "DR", "a write is lost: PWR_CR.DBP is not set")

    def rtc_calibration(self) -> int:
        """Return how many of 2^20 pulses of RTCCLK are left out."""
        return self[RTCCR] & 0x7F

    def write_RTCCR(self, value: int) -> None:
        """Calibrate the RTC, and choose what it puts out at the pin (section 6.4.2)."""
        self[RTCCR] = value
        self._check_pin("RTCCR")
        self.on_calibration()
        self._put_out()

    def _check_pin(self, where: str) -> None:
        if self[RTCCR] & (CCO | ASOE) and self[CR] & TPE:
            self.note("misuse", where, "CCO and ASOE must not be set while TPE has the pin")

    def rtc_clock_changed(self) -> None:
        """RTCCLK has another rate, or stands still, or runs again."""
        self._follow_clock()

    def pulse(self, level: bool) -> None:
        """The RTC tells an alarm or a second: from the rise to the fall of a pulse."""
        if self._puts_out & (CCO | ASOE) == ASOE:
            self._out.set(level)

    def _put_out(self) -> None:
        chosen = self[RTCCR] & (CCO | ASOE | ASOS)
        if chosen == self._puts_out:
            return
        self._puts_out = chosen
        self._follow_clock()
        pulses = chosen & (CCO | ASOE) == ASOE
        if not chosen & CCO:
            self._out.set(False if pulses else None)
        self.on_output(bool(chosen & (CCO | ASOE)), (SECF if chosen & ASOS else ALRF) if pulses else 0)

    def _follow_clock(self) -> None:
        self._clock.follow(self._puts_out, {"RTCCLK": self._rtc_hz() or Fraction(0)})

    def write_CR(self, value: int) -> None:
        """Enable the pin and choose the level that counts as tampering."""
        self[CR] = value
        self._check_pin("CR")
        if value & TPE:
            self._tamper.on_change = self._on_pin
            self._on_pin(self._tamper.level())

    def write_CSR(self, value: int) -> None:
        """CTE and CTI clear TEF and TIF and read 0."""
        if value & CTE:
            value &= ~TEF
        if value & CTI:
            value &= ~TIF
        self[CSR] = value & ~(CTE | CTI)
        if not value & TPIE:
            self[CSR] &= ~TIF
        self._irq.set(bool(self[CSR] & TIF))

    def _on_pin(self, level: bool) -> None:
        active = level is not bool(self[CR] & TPAL)  # TPAL = 0: a high level is tampering
        if not (self[CR] & TPE and active):
            return
        for offset in self._data:
            self[offset] = 0
        self[CSR] |= TEF | TIF if self[CSR] & TPIE else TEF
        self._irq.set(bool(self[CSR] & TIF))
