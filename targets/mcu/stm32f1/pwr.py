"""PWR: the key to the backup domain, and the deep sleep modes (RM0008 section 5).

The supply of the model is 3.3 V and never falls: the voltage detector always answers "above".
"""

from __future__ import annotations

import enum
from fractions import Fraction
from typing import ClassVar

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services

__all__ = ["DeepSleep", "Pwr"]

CR, CSR = 0x00, 0x04
LPDS, PDDS, CWUF, CSBF, PVD_SETTINGS, DBP = 1 << 0, 1 << 1, 1 << 2, 1 << 3, 0xF0, 1 << 8
WUF, SBF, EWUP = 1 << 0, 1 << 1, 1 << 8


class DeepSleep(enum.Enum):
    """Where WFI and WFE lead with SLEEPDEEP set; the value is the typical time to wake up (DS5319, wake-up times)."""

    STOP = Fraction(36, 10_000_000)
    STOP_LOW_POWER = Fraction(54, 10_000_000)
    STANDBY = Fraction(50, 1_000_000)

    @property
    def wakeup_s(self) -> Fraction:
        """Seconds from the event that wakes up to the first instruction."""
        return self.value

    @property
    def is_standby(self) -> bool:
        """True if the mode is left by a reset alone."""
        return self is DeepSleep.STANDBY


class Pwr(Peripheral):
    """Power control; its pin is the input ``WKUP`` (PA0), asked for when EWUP is set.

    The machine asks `deep_sleep` at WFI or WFE with SLEEPDEEP set. In Stop mode it calls `Rcc.stop`, waits for an EXTI
    line, and calls `Rcc.resume`. In Standby it calls `enter_standby` and waits for a reset, which a rising edge of WKUP
    also is, with the cause ``STANDBY``.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("CR", CR, 0, 0x1FF, PVD_SETTINGS, note="the supply never falls as far as the PVD"),
        Register("CSR", CSR, 0, EWUP, fidelity=Fidelity.PARTLY, note="PVDO is always 0: the supply never falls"),
    )

    def __init__(self, base: int, services: Services) -> None:
        super().__init__("PWR", base, services)
        self._wkup = services.input("WKUP")
        self._in_standby = False

    def reset(self) -> None:
        """Go to the state after a reset; WUF and SBF stay."""
        kept = self[CSR] & (WUF | SBF)
        if self[CSR] & EWUP:
            self._wkup.on_change = None
        super().reset()
        self[CSR] = kept
        self._in_standby = False

    def power_on(self) -> None:
        """The supply rises: WUF and SBF are cleared as well."""
        self[CSR] = 0

    def backup_writable(self) -> bool:
        """Say whether DBP opens the backup domain for writing."""
        return bool(self[CR] & DBP)

    def write_CR(self, value: int) -> None:
        """CWUF and CSBF clear their flags and read 0."""
        if value & CWUF:
            self[CSR] &= ~WUF
        if value & CSBF:
            self[CSR] &= ~SBF
        self[CR] = value & ~(CWUF | CSBF)

    def write_CSR(self, value: int) -> None:
        """EWUP; enabling it while WKUP is high is an event (RM0008 section 5.4.2)."""
        changed = (value ^ self[CSR]) & EWUP
        self[CSR] = value
        if changed:
            self._wkup.on_change = self._on_wkup if value & EWUP else None
            self._on_wkup(bool(value & EWUP) and self._wkup.level())

    def deep_sleep(self) -> DeepSleep:
        """Return the mode that CR chooses for SLEEPDEEP."""
        if self[CR] & PDDS:
            return DeepSleep.STANDBY
        return DeepSleep.STOP_LOW_POWER if self[CR] & LPDS else DeepSleep.STOP

    def wakes_by_pin(self) -> bool:
        """Say whether WKUP ends Standby."""
        return bool(self[CSR] & EWUP)

    def enter_standby(self) -> bool:
        """Enter Standby; return False if WUF is still set, which wakes up at once (RM0008 section 5.3.5)."""
        self[CSR] |= SBF
        self._in_standby = not self[CSR] & WUF
        return self._in_standby

    def wake(self) -> None:
        """An alarm of the RTC, or a rise of WKUP: WUF is set, and Standby ends."""
        self[CSR] |= WUF
        if self._in_standby:
            self.services.chip_reset("STANDBY")

    def _on_wkup(self, level: bool) -> None:
        if level:
            self.wake()
