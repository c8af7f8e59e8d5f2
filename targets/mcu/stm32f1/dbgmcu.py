"""DBGMCU: which chip this is, and what a debugger freezes (RM0008 section 31.16)."""

from __future__ import annotations

from typing import ClassVar

from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services

__all__ = ["Dbgmcu"]

IDCODE, CR = 0x00, 0x04
MEDIUM_DENSITY = 0x2003_6410  # DEV_ID 0x410, REV_ID 0x2003 (RM0008 section 31.6.1)
SLEEP_AND_TRACE = 0xE6  # DBG_STOP, DBG_STANDBY, TRACE_IOEN, TRACE_MODE


class Dbgmcu(Peripheral):
    """The registers of the debug support.

    The freeze bits have no effect: while a debugger halts the core, time stands still altogether. IDCODE reads as
    with a debugger attached; without one, silicon of this density gives 0 (ES0340, debug registers).
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("IDCODE", IDCODE, MEDIUM_DENSITY, 0),
        Register("CR", CR, 0, 0x1_FFE7, SLEEP_AND_TRACE, note="sleep modes and trace pins are as without a debugger"),
    )

    def __init__(self, base: int, services: Services) -> None:
        super().__init__("DBGMCU", base, services)

    def reset(self) -> None:
        """Only power-on resets it (RM0008 section 31.16.3)."""

    def power_on(self) -> None:
        """The supply rises."""
        super().reset()

    def read_IDCODE(self) -> int:
        """Which chip this is."""
        self.note("assumed", "IDCODE", "reads as with a debugger attached; without one, silicon gives 0")
        return self[IDCODE]
