"""SYSCFG of the STM32H743 and H753: ports of EXTI lines, over-drive, and what else is there (RM0433 section 12)."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from targets.mcu.fidelity import Fidelity
from targets.mcu.pins import Pins
from targets.mcu.registers import Register
from targets.mcu.services import Services
from targets.mcu.signals import Signals
from targets.mcu.stm32.exti_ports import EXTI_CHOICES, ExtiPorts

__all__ = ["Syscfg"]

PMCR, CFGR, CCCSR, PWRCR, PKGR, UR = 0x04, 0x18, 0x20, 0x2C, 0x124, 0x300
ODEN = 1 << 0
CELL_EN, CELL_READY = 1 << 0, 1 << 8
LQFP144 = 0b0011  # PKG, assumed


class Syscfg(ExtiPorts):
    """System configuration.

    Args:
        base: address.
        services: what the chip offers.
        pins: the pins of the chip.
        signals: the signals it routes.

    Attributes:
        on_over_drive: called when ODEN has changed.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register(
            "PMCR",
            PMCR,
            0x0F00_0000,
            0x0FE0_03FF,
            0x00E0_03FF,
            note="analog switches, fast mode plus and the Ethernet interface are only remembered",
        ),
        *EXTI_CHOICES,
        Register("CFGR", CFGR, 0, 0xFEDD, fidelity=Fidelity.PARTLY, note="lock-up, PVD and ECC errors break nothing"),
        Register(
            "CCCSR", CCCSR, 0, 0x0001_0003, fidelity=Fidelity.PARTLY, note="the compensation cell is ready at once"
        ),
        Register("CCVR", 0x24, 0x88, 0, note="reads a value in the middle (choice)"),
        Register("CCCR", 0x28, 0, 0xFF),
        Register("PWRCR", PWRCR, 0, ODEN),
        Register("PKGR", PKGR, LQFP144, 0),
        *(
            Register(f"UR{number}", UR + 4 * number, 0, 0, fidelity=Fidelity.ABSENT, note="option bytes: see FLASH")
            for number in range(18)
            if number != 1
        ),
    )

    def __init__(self, base: int, services: Services, pins: Pins, signals: Signals) -> None:
        super().__init__("SYSCFG", base, services, pins, signals)
        self.on_over_drive: Callable[[], None] = lambda: None
        self.reset()

    def over_drive(self) -> bool:
        """Say whether ODEN is set."""
        return bool(self[PWRCR] & ODEN)

    def write_CFGR(self, value: int) -> None:
        """Bits once set are cleared by a reset only."""
        self[CFGR] |= value

    def write_CCCSR(self, value: int) -> None:
        """READY follows EN."""
        self[CCCSR] = value | CELL_READY if value & CELL_EN else value & ~CELL_READY

    def write_PWRCR(self, value: int) -> None:
        """Over-drive, which with voltage scale 1 is scale 0."""
        changed = value != self[PWRCR]
        self[PWRCR] = value
        if changed:
            self.on_over_drive()
