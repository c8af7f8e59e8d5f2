"""IWDG: the independent watchdog on its own clock, the LSI (RM0008 section 19; with a window, RM0410 section 30).

The time from a reload to the reset is exactly (reload value + 1) periods of the divided LSI, the figures of RM0008
table 96; silicon adds up to one period of uncertainty. Choices where the manual is silent: an update of PR or RLR takes
the five periods of the LSI that it may take; a second write during an update is lost; a reload during an update follows
when it is done; a change of the prescaler keeps the count and begins a new period. With a window, whether a reload
comes too early is asked when the key is written, of the window in effect; a new window reloads the counter, without
being asked, when its update is done.

With DBGMCU_CR.DBG_IWDG_STOP the counter would stop while a debugger halts the core. Here time itself stands still then.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction
from typing import ClassVar

from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.timebase import Event

__all__ = ["Iwdg"]

KR, PR, RLR, SR, WINR = 0x00, 0x04, 0x08, 0x0C, 0x10
KEY_ACCESS, KEY_RELOAD, KEY_START = 0x5555, 0xAAAA, 0xCCCC
UPDATING = {PR: 1 << 0, RLR: 1 << 1, WINR: 1 << 2}  # PVU, RVU and WVU
UPDATE_CYCLES = 5
FULL = 0xFFF
_WINR = Register("WINR", WINR, FULL, FULL)


class Iwdg(Peripheral):
    """The independent watchdog; once started, nothing but a reset stops it.

    Args:
        base: address of its first register.
        services: what the chip offers.
        lsi_hz: rate of the LSI.
        start_lsi: switches the LSI on for good.
        lsi_on: says whether the LSI is switched on.
        starts_by_itself: says whether the option bytes let it start at reset (WDG_SW = 0).
        window: whether it has the register WINR.

    Attributes:
        runs: it was started and will reset the chip unless it is reloaded.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("KR", KR, 0),
        Register("PR", PR, 0, 0x7),
        Register("RLR", RLR, FULL, FULL),
        Register("SR", SR, 0, 0),
    )

    def __init__(
        self,
        base: int,
        services: Services,
        *,
        lsi_hz: int | Fraction = 40_000,
        start_lsi: Callable[[], None] = lambda: None,
        lsi_on: Callable[[], bool] = lambda: True,
        starts_by_itself: Callable[[], bool] = lambda: False,
        window: bool = False,
    ) -> None:
        self._window = window
        super().__init__("IWDG", base, services)
        self._lsi_hz = Fraction(lsi_hz)
        self._start_lsi = start_lsi
        self._lsi_on = lsi_on
        self._starts_by_itself = starts_by_itself
        self._updates: dict[int, Event] = {}
        self._expiry: Event | None = None
        self.runs = False
        self._open = False
        self._reload_follows = False
        self._count = FULL
        self._since_s = Fraction(0)

    def registers_of(self) -> Iterable[Register]:
        """Return the registers, with or without WINR."""
        return (*self.REGISTERS, _WINR) if self._window else self.REGISTERS

    def reset(self) -> None:
        """Stop, unless the option bytes say that it starts by itself."""
        super().reset()
        for event in (*self._updates.values(), self._expiry):
            self.time.cancel(event)
        self._expiry = None
        self.runs = self._open = self._reload_follows = False
        self._count = FULL
        if self._starts_by_itself():
            self._run()

    # --- registers

    def read_KR(self) -> int:
        """Write-only."""
        return 0

    def write_KR(self, value: int) -> None:
        """0x5555 opens PR, RLR and WINR, 0xAAAA reloads, 0xCCCC starts; whatever is not 0x5555 closes them again."""
        key = value & 0xFFFF
        self._open = key == KEY_ACCESS
        if key == KEY_RELOAD and self._too_early():
            self._expire()
        elif key == KEY_RELOAD and self[SR]:
            self._reload_follows = True
        elif key == KEY_RELOAD:
            self._reload(self[RLR])
        elif key == KEY_START and not self.runs:
            self._run()

    def write_PR(self, value: int) -> None:
        """Choose the prescaler, 4 to 256."""
        self._update(PR, value)

    def write_RLR(self, value: int) -> None:
        """Choose the reload value."""
        self._update(RLR, value)

    def write_WINR(self, value: int) -> None:
        """Choose the window: a reload while the counter is above it resets the chip."""
        self._update(WINR, value)

    def _too_early(self) -> bool:
        return self._window and self.runs and self._counted_to() > self[WINR]

    # --- updates, which take their time

    def _update(self, offset: int, value: int) -> None:
        name = self.registers[offset].name
        if not self._open:
            self.note("misuse", name, "is write-protected: write 0x5555 to IWDG_KR first")
        elif self[SR] & UPDATING[offset]:
            self.note("misuse", name, "a write during an update is lost; wait for IWDG_SR first")
        else:
            if not self._lsi_on():
                self.note("assumed", name, "the update is carried out although the LSI is off; silicon may wait for it")
            self[SR] |= UPDATING[offset]
            self._updates[offset] = self._in(Fraction(UPDATE_CYCLES), lambda: self._finish_update(offset, value))

    def _finish_update(self, offset: int, value: int) -> None:
        count = self._counted_to()
        self[offset] = value
        self[SR] &= ~UPDATING[offset]
        if offset == WINR or (self._reload_follows and not self[SR]):
            self._reload_follows = self._reload_follows and bool(self[SR])
            self._reload(self[RLR])
        elif offset == PR:
            self._reload(count)

    def _in(self, lsi_cycles: Fraction, action: Callable[[], None]) -> Event:
        time = self.time
        return time.at_time(time.seconds(time.now) + lsi_cycles / self._lsi_hz, action)

    # --- counting

    def _divider(self) -> int:
        return 4 << min(self[PR], 6)

    def _run(self) -> None:
        self._start_lsi()
        self.runs = True
        self._reload(self._count)

    def _reload(self, count: int) -> None:
        """Count down from `count`, from now on."""
        self._count = count
        self._since_s = self.time.seconds(self.time.now)
        if self.runs:
            self.time.cancel(self._expiry)
            self._expiry = self._in(Fraction((count + 1) * self._divider()), self._expire)

    def _counted_to(self) -> int:
        """Return the present value of the counter."""
        if not self.runs:
            return self._count
        elapsed_s = self.time.seconds(self.time.now) - self._since_s
        return max(self._count - int(elapsed_s * self._lsi_hz / self._divider()), 0)

    def _expire(self) -> None:
        self.time.cancel(self._expiry)
        self.runs = False
        self.services.chip_reset("IWDG")
