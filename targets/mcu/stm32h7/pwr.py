"""PWR of the STM32H743 and H753: the supply, voltage scaling, deep sleep (RM0433 section 6).

After power-on the chip is in Run*: the supply configuration in CR3 has to be written once, and only then is a voltage
ready and VOS obeyed. The supply of the model is 3.3 V and never falls; temperature and VBAT are what they should be.

Choices: nothing draws current, so LPDS, SVOS, FLPS and STOPF change nothing; with CPU and both domains together there
are Stop, and Standby if all three PDDS bits are set; the backup regulator is ready at once. A new scale holds at once
where it is lower, and when VOSRDY comes where it is higher. How long both take is assumed.
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

__all__ = ["WAKE_UP_PINS", "DeepSleep", "Pwr"]

CR1, CSR1, CR2, CR3, CPUCR, D3CR, WKUPCR, WKUPFR, WKUPEPR = 0x00, 0x04, 0x08, 0x0C, 0x10, 0x18, 0x20, 0x24, 0x28

DBP = 1 << 8
ACTVOSRDY, ACTVOS = 1 << 13, 3 << 14
BREN, BRRDY = 1 << 0, 1 << 16
BYPASS, LDOEN, SCUEN, USB33DEN, USB33RDY = 1 << 0, 1 << 1, 1 << 2, 1 << 24, 1 << 26
SUPPLY = BYPASS | LDOEN | SCUEN
PDDS, STOPF, SBF, SBF_D1, SBF_D2, CSSF = 7, 1 << 5, 1 << 6, 1 << 7, 1 << 8, 1 << 9
VOSRDY, VOS = 1 << 13, 3 << 14
PINS = 0x3F

# Pins of WKUP1 to WKUP6 (DS12117, additional functions).
WAKE_UP_PINS = ("PA0", "PA2", "PI8", "PC13", "PI11", "PC1")
SUPPLY_S = Fraction(10, 1_000_000)
SCALE_S = Fraction(10, 1_000_000)


class DeepSleep(enum.Enum):
    """Where WFI and WFE lead with SLEEPDEEP set; the value is the time to wake up, assumed after DS12117."""

    STOP = Fraction(44, 10_000_000)
    STANDBY = Fraction(400, 1_000_000)

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
        over_drive: returns SYSCFG_PWRCR.ODEN.
        on_scale: called when the voltage scale has changed.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("CR1", CR1, 0xF000_C000, 0x0007_C3F1, 0x0001_0010, note="the supply never falls to PVD or AVD"),
        Register("CSR1", CSR1, 0x4000, 0, fidelity=Fidelity.PARTLY, note="PVDO and AVDO are always 0"),
        Register("CR2", CR2, 0, BREN | 1 << 4, fidelity=Fidelity.PARTLY, note="no alarm of VBAT or temperature"),
        Register("CR3", CR3, LDOEN | SCUEN, SUPPLY | 3 << 8 | 3 << 24, fidelity=Fidelity.PARTLY, note="VBAT is full"),
        Register("CPUCR", CPUCR, 0, PDDS | CSSF | 1 << 11, fidelity=Fidelity.PARTLY, note="domains sleep together"),
        Register("D3CR", D3CR, 0x4000, VOS),
        Register("WKUPCR", WKUPCR, 0, PINS),
        Register("WKUPFR", WKUPFR, 0, 0),
        Register("WKUPEPR", WKUPEPR, 0, 0x0FFF_3F3F, fidelity=Fidelity.PARTLY, note="pulls of the pins are left out"),
    )

    def __init__(self, base: int, services: Services) -> None:
        super().__init__("PWR", base, services)
        self.on_scale: Callable[[], None] = lambda: None
        self.over_drive: Callable[[], bool] = lambda: False
        self._inputs = [services.input(f"WKUP{number}") for number in range(1, 7)]
        self._scale = 3
        self._in_standby = False
        self._supplied = False
        self._event: Event | None = None

    # --- what the chip calls

    def reset(self) -> None:
        """Go to the state after a reset; the supply configuration and what says how Standby was left stay."""
        kept = {CR3: self[CR3], WKUPFR: self[WKUPFR], WKUPEPR: self[WKUPEPR], CR2: self[CR2]}
        flags = self[CPUCR] & (STOPF | SBF | SBF_D1 | SBF_D2)
        super().reset()
        self.time.cancel(self._event)
        for offset, value in kept.items():
            self[offset] = value
        self[CPUCR] |= flags
        self._in_standby = False
        if self._supplied:
            self[CSR1] |= ACTVOSRDY
            self[D3CR] |= VOSRDY
        self._take_scale()

    def power_on(self) -> None:
        """The supply rises: the chip is in Run*, and CR3 can be written once."""
        self._supplied = False
        super().reset()
        self._listen()

    def backup_writable(self) -> bool:
        """Say whether DBP opens the backup domain for writing."""
        return bool(self[CR1] & DBP)

    def scale(self) -> int:
        """Return the voltage scale, 0 to 3; 0 is scale 1 with over-drive."""
        return self._scale

    def over_drive_changed(self) -> None:
        """SYSCFG_PWRCR.ODEN has changed."""
        if self.over_drive() and self[D3CR] & VOS != VOS:
            text = "over-drive without voltage scale 1 has no effect"
            self.services.notes.add("misuse", "SYSCFG_PWRCR.ODEN", text)
        self._change_scale()

    # --- registers

    def write_CR2(self, value: int) -> None:
        """BREN: the backup regulator is ready at once."""
        self[CR2] = value | BRRDY if value & BREN else value & ~BRRDY

    def write_CR3(self, value: int) -> None:
        """The supply: once after power-on; then USB's, which is ready at once."""
        if self._supplied:
            if (value ^ self[CR3]) & (BYPASS | LDOEN):
                self.note("misuse", "CR3", "the supply was configured before: it keeps its value until power-off")
            value = (value & ~SUPPLY) | (self[CR3] & SUPPLY)
        else:
            self._supplied = True
            if not value & (BYPASS | LDOEN):
                self.note("misuse", "CR3.LDOEN", "no supply is chosen: silicon would stand still here")
            value &= ~SCUEN
            self._event = self._after(SUPPLY_S, self._supply_ready)
        self[CR3] = value | USB33RDY if value & USB33DEN else value & ~USB33RDY

    def _supply_ready(self) -> None:
        self[CSR1] |= ACTVOSRDY
        self._scale_ready()

    def write_CPUCR(self, value: int) -> None:
        """CSSF clears the flags of Stop and Standby, and reads 0."""
        if value & CSSF:
            value &= ~(STOPF | SBF | SBF_D1 | SBF_D2)
        self[CPUCR] = value & ~CSSF

    def write_D3CR(self, value: int) -> None:
        """VOS, which is obeyed once the supply is configured."""
        if value & VOS == 0:
            self.note("reserved", "D3CR.VOS", "the value 00 is reserved: taken for scale 3")
        changed = (value ^ self[D3CR]) & VOS
        self[D3CR] = value
        if changed and not self._supplied:
            self.note("misuse", "D3CR.VOS", "the supply was not configured in CR3: the voltage does not change")
        elif changed:
            self._change_scale()

    def _change_scale(self) -> None:
        if not self._supplied:
            return
        self[D3CR] &= ~VOSRDY
        self[CSR1] &= ~ACTVOSRDY
        self.time.cancel(self._event)
        if self._wanted() > self._scale:
            self._take_scale()
        self._event = self._after(SCALE_S, self._supply_ready)

    def _scale_ready(self) -> None:
        self[D3CR] |= VOSRDY
        self[CSR1] = (self[CSR1] & ~ACTVOS) | self[D3CR] & VOS
        self._take_scale()

    def _wanted(self) -> int:
        chosen = max(self[D3CR] >> 14 & 3, 1)
        return 0 if chosen == 3 and self.over_drive() else 4 - chosen

    def _take_scale(self) -> None:
        if self._wanted() != self._scale:
            self._scale = self._wanted()
            self.on_scale()

    def _after(self, seconds: Fraction, action: Callable[[], None]) -> Event:
        return self.time.at_time(self.time.seconds(self.time.now) + seconds, action)

    # --- wake-up pins

    def read_WKUPCR(self) -> int:
        """Write-only: reads 0."""
        return 0

    def write_WKUPCR(self, value: int) -> None:
        """Clear flags by writing 1."""
        self[WKUPFR] &= ~value

    def write_WKUPEPR(self, value: int) -> None:
        """Enable pins; one that is at its level already is an event."""
        enabled = value & ~self[WKUPEPR] & PINS
        self[WKUPEPR] = value
        self._listen()
        for number, signal in enumerate(self._inputs):
            if enabled >> number & 1:
                self._on_pin(number, signal.level())

    def _listen(self) -> None:
        for number, signal in enumerate(self._inputs):
            signal.on_change = self._listener(number) if self[WKUPEPR] >> number & 1 else None

    def _listener(self, number: int) -> Callable[[bool], None]:
        return lambda level: self._on_pin(number, level)

    def _on_pin(self, number: int, level: bool) -> None:
        if level is bool(self[WKUPEPR] >> 8 + number & 1):
            return  # WKUPP 1: the falling edge
        self[WKUPFR] |= 1 << number
        if self._in_standby:
            self.services.chip_reset("STANDBY")

    # --- deep sleep

    def deep_sleep(self) -> DeepSleep:
        """Return the mode for SLEEPDEEP: Standby if all domains may go there."""
        if self[CPUCR] & PDDS == PDDS:
            return DeepSleep.STANDBY
        if self[CPUCR] & PDDS:
            text = "Standby of single domains is not modelled: they stop"
            self.services.notes.add("unmodelled", "PWR_CPUCR.PDDS", text)
        return DeepSleep.STOP

    def enter_stop(self) -> None:
        """Enter Stop mode."""
        self[CPUCR] |= STOPF

    def may_wake(self) -> bool:
        """Say whether a pin may end Standby, or the RTC, which always may."""
        return True

    def wake_by_rtc(self) -> None:
        """An alarm, wake-up, tamper or time stamp of the RTC ends Standby."""
        if self._in_standby:
            self.services.chip_reset("STANDBY")

    def enter_standby(self) -> bool:
        """Enter Standby; return False if a wake-up flag is still set, which wakes up at once."""
        self[CPUCR] |= SBF | SBF_D1 | SBF_D2
        self._in_standby = not self[WKUPFR] & self[WKUPEPR] & PINS
        return self._in_standby
