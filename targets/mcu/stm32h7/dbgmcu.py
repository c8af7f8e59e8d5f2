"""DBGMCU of the STM32H743 and H753: which chip this is, and what a debugger freezes (RM0433 section 60.5.8)."""

from __future__ import annotations

from typing import ClassVar

from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services

__all__ = ["Dbgmcu"]

IDC, CR = 0x00, 0x04
STM32H7 = 0x2003_6450  # DEV_ID 0x450, REV_ID 0x2003: revision V
FREEZES = "while a debugger halts the core, time stands still altogether"


class Dbgmcu(Peripheral):
    """The registers of the debug support. The freeze bits have no effect."""

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("IDC", IDC, STM32H7, 0),
        Register("CR", CR, 0, 0x1070_0187, 0x1070_0187, note="sleep modes and trace pins are as without it"),
        Register("APB3FZ1", 0x34, 0, 1 << 6, note=FREEZES),
        Register("APB1LFZ1", 0x3C, 0, 0x00E0_03FF, note=FREEZES),
        Register("APB1HFZ1", 0x44, 0, 1 << 8, note=FREEZES),
        Register("APB2FZ1", 0x4C, 0, 0x2007_0003, note=FREEZES),
        Register("APB4FZ1", 0x54, 0, 0x0005_1E80, note=FREEZES),
    )

    def __init__(self, base: int, services: Services) -> None:
        super().__init__("DBGMCU", base, services)

    def reset(self) -> None:
        """Only power-on resets it."""

    def power_on(self) -> None:
        """The supply rises."""
        super().reset()
