"""DBGMCU of the STM32F76x: which chip this is, and what a debugger freezes (RM0410 section 40.16)."""

from __future__ import annotations

from typing import ClassVar

from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services

__all__ = ["Dbgmcu"]

IDCODE, CR, APB1_FZ, APB2_FZ = range(0x00, 0x10, 4)
STM32F76 = 0x1001_6451  # DEV_ID 0x451, REV_ID 0x1001: revision Z (RM0410 section 40.6.1)
SLEEP_AND_TRACE = 0xE7  # DBG_SLEEP, DBG_STOP, DBG_STANDBY, TRACE_IOEN, TRACE_MODE
FREEZES = "while a debugger halts the core, time stands still altogether"


class Dbgmcu(Peripheral):
    """The registers of the debug support. The freeze bits have no effect."""

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("IDCODE", IDCODE, STM32F76, 0),
        Register("CR", CR, 0, SLEEP_AND_TRACE, SLEEP_AND_TRACE, note="sleep modes and trace pins are as without it"),
        Register("APB1_FZ", APB1_FZ, 0, 0x07E0_3FFF, note=FREEZES),
        Register("APB2_FZ", APB2_FZ, 0, 0x0007_0003, note=FREEZES),
    )

    def __init__(self, base: int, services: Services) -> None:
        super().__init__("DBGMCU", base, services)

    def reset(self) -> None:
        """Only power-on resets it (RM0410 section 40.16.2)."""

    def power_on(self) -> None:
        """The supply rises."""
        super().reset()
