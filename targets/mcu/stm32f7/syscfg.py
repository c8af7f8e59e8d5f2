"""SYSCFG of the STM32F76x: which port an EXTI line has, and what else is configured there (RM0410 section 7)."""

from __future__ import annotations

from typing import ClassVar

from targets.mcu.fidelity import Fidelity
from targets.mcu.pins import Pins
from targets.mcu.registers import Register
from targets.mcu.services import Services
from targets.mcu.signals import Signals
from targets.mcu.stm32.exti_ports import EXTI_CHOICES, ExtiPorts

__all__ = ["Syscfg"]

MEMRMP, PMC, CBR, CMPCR = 0x00, 0x04, 0x1C, 0x20
MEM_BOOT, SWP_FB = 1 << 0, 1 << 8
CMP_PD, CMP_READY = 1 << 0, 1 << 8


class Syscfg(ExtiPorts):
    """System configuration.

    Args:
        base: address.
        services: what the chip offers.
        pins: the pins of the chip.
        signals: the signals it routes.
        boot_pin: the level of the BOOT pin, which MEM_BOOT shows.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("MEMRMP", MEMRMP, 0, 0xD00, 0xD00, note="banks and external memories are never swapped"),
        Register("PMC", PMC, 0, 0x0087_00FF, 0x0087_00FF, note="fast mode plus, ADC and Ethernet options are kept"),
        *EXTI_CHOICES,
        Register("CBR", CBR, 0, 0x5, fidelity=Fidelity.PARTLY, note="lock-up and PVD break nothing"),
        Register("CMPCR", CMPCR, 0, CMP_PD, fidelity=Fidelity.PARTLY, note="the compensation cell is ready at once"),
    )

    def __init__(self, base: int, services: Services, pins: Pins, signals: Signals, *, boot_pin: int) -> None:
        super().__init__("SYSCFG", base, services, pins, signals)
        self._boot_pin = boot_pin
        self.reset()

    def reset(self) -> None:
        """Every EXTI line goes to port A."""
        super().reset()
        self[MEMRMP] = MEM_BOOT if self._boot_pin else 0

    def write_CBR(self, value: int) -> None:
        """Bits once set are cleared by a reset only."""
        self[CBR] |= value

    def write_CMPCR(self, value: int) -> None:
        """READY follows CMP_PD."""
        self[CMPCR] = value | CMP_READY if value & CMP_PD else 0
