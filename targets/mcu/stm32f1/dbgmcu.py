"""DBGMCU: which chip this is, and what a debugger freezes (RM0008 section 31.16)."""

from __future__ import annotations

from collections.abc import Iterable

from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.stm32f1.densities import MEDIUM, Density

__all__ = ["Dbgmcu"]

IDCODE, CR = 0x00, 0x04
SLEEP_AND_TRACE = 0xE6  # DBG_STOP, DBG_STANDBY, TRACE_IOEN, TRACE_MODE
SLEEP = 0xE7  # these, and DBG_SLEEP


class Dbgmcu(Peripheral):
    """The registers of the debug support.

    The freeze bits have no effect: while a debugger halts the core, time stands still altogether. IDCODE reads as
    with a debugger attached; without one, silicon gives 0 (ES0340, debug registers, of medium density).

    Args:
        base: address of its first register.
        services: what the chip offers.
        density: which chip this is.
    """

    def __init__(self, base: int, services: Services, density: Density = MEDIUM) -> None:
        self._density = density
        super().__init__("DBGMCU", base, services)

    def registers_of(self) -> Iterable[Register]:
        """Return the registers of this density."""
        note = "sleep modes and trace pins are as without a debugger"
        yield Register("IDCODE", IDCODE, self._density.idcode, 0)
        yield Register("CR", CR, 0, SLEEP | self._density.freezes, SLEEP_AND_TRACE, note=note)

    def reset(self) -> None:
        """Only power-on resets it (RM0008 section 31.16.3)."""

    def power_on(self) -> None:
        """The supply rises."""
        super().reset()

    def read_IDCODE(self) -> int:
        """Which chip this is."""
        self.note("assumed", "IDCODE", "reads as with a debugger attached; without one, silicon gives 0")
        return self[IDCODE]
