"""WWDG: the window watchdog on PCLK1 (RM0008 section 20; the same in RM0410 section 31).

The down-counter runs as long as its clock does, watchdog or not. Choices where the manual is silent: the divider by
4096 begins anew with every write to CR and with a change of WDGTB, so that the time to the reset is exactly
4096 x 2^WDGTB x (T[5:0] + 1) cycles of PCLK1.
"""

from __future__ import annotations

from typing import ClassVar

from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.timebase import Event

__all__ = ["Wwdg"]

IRQ = 0
CR, CFR, SR = 0x00, 0x04, 0x08
T, T6, WDGA = 0x7F, 0x40, 1 << 7
W, WDGTB, EWI = 0x7F, 0x180, 1 << 9
EWIF = 1 << 0


class Wwdg(Peripheral):
    """The window watchdog.

    Args:
        base: address.
        services: what the chip offers.
        bus: the bus whose clock it counts.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("CR", CR, T, T | WDGA, live=True),
        Register("CFR", CFR, W, W | WDGTB | EWI),
        Register("SR", SR, 0, EWIF),
    )

    def __init__(self, base: int, services: Services, *, bus: str = "APB1") -> None:
        self._bus = bus
        super().__init__("WWDG", base, services)
        self._irq = services.irq(IRQ)
        self._event: Event | None = None
        # The counter stood at `_count` at cycle `_since`, with so many ticks of PCLK1 of its period gone.
        self._count = T
        self._since = 0
        self._ticks = 0
        self._period = 0  # HCLK cycles per tick of PCLK1; 0 stands still
        self._restart()

    @property
    def runs(self) -> bool:
        """True once it has been started, until the next reset."""
        return bool(self[CR] & WDGA)

    def reset(self) -> None:
        """Stop; the counter is at 0x7F and counts on while its clock runs."""
        super().reset()
        self._irq.set(False)
        self._load(T)

    def before_clock_change(self) -> None:
        """Count up to now."""
        self._settle()

    def after_clock_change(self) -> None:
        """Go on at the new rate."""
        self._restart()

    # --- registers

    def read_CR(self) -> int:
        """WDGA and the counter."""
        self._settle()
        return (self[CR] & WDGA) | self._count

    def write_CR(self, value: int) -> None:
        """Refresh the counter and perhaps start; outside the window, or with T6 clear, that is a reset."""
        was_on = self[CR] & WDGA
        self._settle()
        too_early = was_on and self._count > self[CFR] & W
        self[CR] = value | was_on  # only a reset clears WDGA
        if self[CR] & WDGA and (too_early or not value & T6):
            self.services.chip_reset("WWDG")
            return
        self._load(value & T)

    def write_CFR(self, value: int) -> None:
        """Window, divider and early wake-up interrupt, which only a reset disables again."""
        self._settle()
        if (value ^ self[CFR]) & WDGTB:
            self._ticks = 0
        self[CFR] = value | (self[CFR] & EWI)
        self._drive_irq()
        self._restart()

    def write_SR(self, value: int) -> None:
        """EWIF is cleared by writing 0; writing 1 has no effect."""
        self[SR] &= value
        self._drive_irq()

    def _drive_irq(self) -> None:
        self._irq.set(bool(self[SR] & EWIF and self[CFR] & EWI))

    # --- counting

    def _ticks_per_count(self) -> int:
        return 4096 << (self[CFR] >> 7 & 3)

    def _load(self, count: int) -> None:
        self._count = count
        self._ticks = 0
        self._since = self.time.now
        self._restart()

    def _settle(self) -> None:
        """Bring `_count` and `_ticks` up to the present cycle."""
        now = self.time.now
        if self._period:
            gone = (now - self._since) // self._period
            self._since += gone * self._period
            steps, self._ticks = divmod(self._ticks + gone, self._ticks_per_count())
            self._count = (self._count - steps) & T
        else:
            self._since = now

    def _restart(self) -> None:
        """Enter the next event anew: the counter reaching 0x40, or falling below it while the watchdog is on."""
        self.time.cancel(self._event)
        self._period = self.services.clocks.pclk(self._bus) if self.clocked else 0
        if not self._period:
            return
        target = T6 if self._count != T6 else T6 - 1
        steps = (self._count - target) & T or T + 1
        ticks = steps * self._ticks_per_count() - self._ticks
        self._event = self.time.at(self._since + ticks * self._period, self._reached)

    def _reached(self) -> None:
        self._settle()
        if self._count == T6:
            self[SR] |= EWIF
            self._drive_irq()
        elif self[CR] & WDGA:
            self.services.chip_reset("WWDG")
            return
        self._restart()
