"""BKP: half-words that survive everything but power-off and tampering (RM0008 section 6)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import ClassVar

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.stm32f1.densities import MEDIUM, Density

__all__ = ["Bkp"]

TAMPER_IRQ = 2
DATA = (*range(0x04, 0x2C, 4), *range(0x40, 0xC0, 4))  # DR1 to DR10, DR11 to DR42
RTCCR, CR, CSR = 0x2C, 0x30, 0x34
TPE, TPAL = 1 << 0, 1 << 1
CTE, CTI, TPIE, TEF, TIF = 1 << 0, 1 << 1, 1 << 2, 1 << 8, 1 << 9


class Bkp(Peripheral):
    """Backup registers and tamper detection.

    Args:
        base: address of its first register.
        services: what the chip offers; the pin is its input ``TAMPER``, asked for when TPE is set.
        backup_writable: says whether PWR_CR.DBP opens the backup domain; without it writes are lost.
        density: says how many half-words there are.

    Attributes:
        on_calibration: called when `rtc_calibration` may have changed.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register(
            "RTCCR",
            RTCCR,
            0,
            0x3FF,
            0x380,
            fidelity=Fidelity.PARTLY,
            note="the outputs of the RTC (CCO, ASOE, ASOS) are not modelled",
        ),
        Register("CR", CR, 0, TPE | TPAL),
        Register("CSR", CSR, 0, CTE | CTI | TPIE),
    )

    def __init__(
        self, base: int, services: Services, *, backup_writable: Callable[[], bool], density: Density = MEDIUM
    ) -> None:
        self._data = DATA[: density.backup_registers]
        super().__init__("BKP", base, services)
        self._writable = backup_writable
        self.on_calibration: Callable[[], None] = lambda: None
        self._irq = services.irq(TAMPER_IRQ)
        self._tamper = services.input("TAMPER")

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
        """Calibrate the RTC."""
        self[RTCCR] = value
        self.on_calibration()

    def write_CR(self, value: int) -> None:
        """Enable the pin and choose the level that counts as tampering."""
        self[CR] = value
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
