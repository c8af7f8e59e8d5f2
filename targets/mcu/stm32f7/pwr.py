"""PWR of the STM32F76x: voltage scaling and over-drive, the key to the backup domain, deep sleep (RM0410 section 4).

The supply of the model is 3.3 V and never falls: the voltage detector always answers "above".

Choices: nothing draws current, so LPDS and FPDS change only how long waking up takes, and LPUDS, MRUDS and UDEN
nothing; the backup regulator is ready at once; a new voltage scale holds from when the PLL is switched on (section
4.1.4), and VOSRDY is always set. Over-drive takes 45 us, typical with HSI (DS11532, over-drive switching), all of
them between ODSWEN and ODSWRDY; ODRDY follows ODEN at once.
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from fractions import Fraction
from typing import ClassVar

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.timebase import Event

__all__ = ["DeepSleep", "Pwr"]

CR1, CSR1, CR2, CSR2 = 0x00, 0x04, 0x08, 0x0C

LPDS, PDDS, CSBF, DBP, FPDS, LPUDS, MRUDS = 1 << 0, 1 << 1, 1 << 3, 1 << 8, 1 << 9, 1 << 10, 1 << 11
PVD_SETTINGS, ADCDC1, VOS, ODEN, ODSWEN, UDEN = 0xF0, 1 << 13, 3 << 14, 1 << 16, 1 << 17, 3 << 18
WUIF, SBF, BRR, EIWUP, BRE = 1 << 0, 1 << 1, 1 << 3, 1 << 8, 1 << 9
VOSRDY, ODRDY, ODSWRDY, UDRDY = 1 << 14, 1 << 16, 1 << 17, 3 << 18
PINS = 0x3F

# Pins of WKUP1 to WKUP6 (DS11532, additional functions); packages of up to 144 pins lack the last two.
WAKE_UP_PINS = ("PA0", "PA2", "PC1", "PC13", "PI8", "PI11")
OVER_DRIVE_S = Fraction(45, 1_000_000)


class DeepSleep(enum.Enum):
    """Where WFI and WFE lead with SLEEPDEEP set.

    The value is the time to wake up; assumed, of the order that DS11532 gives for its wake-up times.
    """

    STOP = Fraction(128, 10_000_000)  # main regulator, flash in Stop
    STOP_FLASH_OFF = Fraction(105, 1_000_000)
    STOP_LOW_POWER = Fraction(20, 1_000_000)
    STOP_LOW_POWER_FLASH_OFF = Fraction(112, 1_000_000)
    STANDBY = Fraction(308, 1_000_000)

    @property
    def wakeup_s(self) -> Fraction:
        """Seconds from the event that wakes up to the first instruction."""
        return self.value

    @property
    def is_standby(self) -> bool:
        """True if the mode is left by a reset alone."""
        return self is DeepSleep.STANDBY


class Pwr(Peripheral):
    """Power control; its pins are the inputs ``WKUP1`` to ``WKUP6``.

    Args:
        base: address of CR1.
        services: what the chip offers.

    Attributes:
        on_supply: called when voltage scale or over-drive have changed.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register(
            "CR1",
            CR1,
            VOS,
            LPDS | PDDS | CSBF | PVD_SETTINGS | DBP | FPDS | LPUDS | MRUDS | ADCDC1 | VOS | ODEN | ODSWEN | UDEN,
            PVD_SETTINGS,
            note="the supply never falls as far as the PVD",
        ),
        Register("CSR1", CSR1, VOSRDY, EIWUP | BRE, fidelity=Fidelity.PARTLY, note="PVDO is always 0"),
        Register("CR2", CR2, 0, PINS | PINS << 8),
        Register("CSR2", CSR2, 0, PINS << 8),
    )

    def __init__(self, base: int, services: Services) -> None:
        super().__init__("PWR", base, services)
        self.on_supply: Callable[[], None] = lambda: None
        self._inputs = [services.input(f"WKUP{number}") for number in range(1, 7)]
        self._scale = 1
        self._pll_on = False
        self._in_standby = False
        self._over_drive: Event | None = None

    # --- what the chip calls

    def reset(self) -> None:
        """Go to the state after a reset; what says how Standby was left stays, and so does the backup regulator."""
        kept_csr1, kept_csr2 = self[CSR1] & (WUIF | SBF | BRE | BRR | EIWUP), self[CSR2]
        super().reset()
        self.time.cancel(self._over_drive)
        self[CSR1] |= kept_csr1
        self[CSR2] = kept_csr2
        self._in_standby = False
        self._take_scale()

    def power_on(self) -> None:
        """The supply rises: all is as in the manual."""
        self[CSR1], self[CSR2] = VOSRDY, 0
        self._listen()

    def backup_writable(self) -> bool:
        """Say whether DBP opens the backup domain for writing."""
        return bool(self[CR1] & DBP)

    def supply(self) -> tuple[int, bool]:
        """Return the voltage scale, 1 to 3, and whether over-drive is switched on."""
        return self._scale, bool(self[CSR1] & ODSWRDY)

    def pll_switched(self, on: bool) -> None:
        """The PLL is switched on or off; on, it lets a new voltage scale hold."""
        self._pll_on = on
        if on:
            self._take_scale()

    def _take_scale(self) -> None:
        scale = 4 - max(self[CR1] >> 14 & 3, 1)
        if scale != self._scale:
            self._scale = scale
            self.on_supply()

    # --- registers

    def write_CR1(self, value: int) -> None:
        """CSBF clears its flag and reads 0; VOS is taken while the PLL is off; over-drive takes its time."""
        old = self[CR1]
        if value & CSBF:
            self[CSR1] &= ~SBF
        if (value ^ old) & VOS and self._pll_on:
            self.note("misuse", "CR1.VOS", "can be changed only while the PLL is off; it keeps its value")
            value = (value & ~VOS) | (old & VOS)
        elif not value & VOS:
            self.note("reserved", "CR1.VOS", "the value 00 is reserved: taken for scale 3")
        self[CR1] = value & ~CSBF
        self._switch_over_drive(value, value ^ old)

    def _switch_over_drive(self, value: int, changed: int) -> None:
        if changed & ODEN:
            self[CSR1] = self[CSR1] | ODRDY if value & ODEN else self[CSR1] & ~ODRDY
        if not changed & ODSWEN:
            return
        self.time.cancel(self._over_drive)
        if not value & ODSWEN:
            self._set_over_drive(False)
        elif self[CSR1] & ODRDY:
            time = self.time
            when_s = time.seconds(time.now) + OVER_DRIVE_S
            self._over_drive = time.at_time(when_s, lambda: self._set_over_drive(True))
        else:
            self.note("misuse", "CR1.ODSWEN", "over-drive is not ready: ODEN comes first, then ODRDY")

    def _set_over_drive(self, on: bool) -> None:
        self[CSR1] = self[CSR1] | ODSWRDY if on else self[CSR1] & ~ODSWRDY
        self.on_supply()

    def write_CSR1(self, value: int) -> None:
        """BRE, the backup regulator, is ready at once; EIWUP lets events of the RTC end Standby."""
        self[CSR1] = value | BRR if value & BRE else value & ~BRR

    def write_CR2(self, value: int) -> None:
        """WUPP chooses the edge of each pin; CWUPF clears its flag and reads 0."""
        self[CSR2] &= ~(value & PINS)
        self[CR2] = value & ~PINS

    def write_CSR2(self, value: int) -> None:
        """EWUP; enabling a pin that is at its level already is an event (RM0410 section 4.4.4)."""
        changed = (value ^ self[CSR2]) >> 8 & PINS
        self[CSR2] = value
        self._listen()
        for number in range(len(self._inputs)):
            if changed & value >> 8 & 1 << number:
                self._on_pin(number, self._inputs[number].level())

    def _listen(self) -> None:
        for number, signal in enumerate(self._inputs):
            enabled = self[CSR2] >> 8 + number & 1
            signal.on_change = self._listener(number) if enabled else None

    def _listener(self, number: int) -> Callable[[bool], None]:
        return lambda level: self._on_pin(number, level)

    def _on_pin(self, number: int, level: bool) -> None:
        if level is bool(self[CR2] >> 8 + number & 1):
            return  # WUPP 1: the falling edge
        self[CSR2] |= 1 << number
        if self._in_standby:
            self.services.chip_reset("STANDBY")

    # --- deep sleep

    def deep_sleep(self) -> DeepSleep:
        """Return the mode that CR1 chooses for SLEEPDEEP."""
        control = self[CR1]
        if control & PDDS:
            return DeepSleep.STANDBY
        if control & LPDS:
            return DeepSleep.STOP_LOW_POWER_FLASH_OFF if control & FPDS else DeepSleep.STOP_LOW_POWER
        return DeepSleep.STOP_FLASH_OFF if control & FPDS else DeepSleep.STOP

    def may_wake(self) -> bool:
        """Say whether a pin or the RTC may end Standby."""
        return bool(self[CSR2] >> 8 & PINS or self[CSR1] & EIWUP)

    def wake_by_rtc(self) -> None:
        """An alarm, wake-up, tamper or time stamp of the RTC; it ends Standby if EIWUP is set."""
        if self[CSR1] & EIWUP:
            self[CSR1] |= WUIF
            if self._in_standby:
                self.services.chip_reset("STANDBY")
        elif self._in_standby:
            self.note("misuse", "CSR1.EIWUP", "is not set: what comes from the RTC does not end Standby mode")

    def enter_stop(self) -> None:
        """Enter Stop mode: over-drive is switched off (RM0410 section 4.3.5)."""
        self.time.cancel(self._over_drive)
        self[CR1] &= ~(ODEN | ODSWEN)
        self[CSR1] &= ~(ODRDY | ODSWRDY)

    def enter_standby(self) -> bool:
        """Enter Standby; return False if a wake-up flag is still set, which wakes up at once (RM0410 section 4.3.6)."""
        self[CSR1] |= SBF
        self._in_standby = not (self[CSR1] & WUIF or self[CSR2] & PINS)
        return self._in_standby
