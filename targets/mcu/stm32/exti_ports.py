"""The registers of SYSCFG that choose the port of each EXTI line (RM0410 section 7.2.3, RM0433 section 12.3.2)."""

from __future__ import annotations

from targets.mcu.pins import Pins
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.signals import Signals

__all__ = ["EXTI_CHOICES", "ExtiPorts"]

_FIRST, _PORTS = 0x08, "ABCDEFGHIJK"

EXTI_CHOICES = tuple(Register(f"EXTICR{number + 1}", _FIRST + 4 * number, 0, 0xFFFF) for number in range(4))
"""The registers, of the same offsets in all families that have them."""


class ExtiPorts(Peripheral):
    """A SYSCFG with these registers.

    Args:
        name: ``SYSCFG``.
        base: address.
        services: what the chip offers.
        pins: the pins of the chip.
        signals: the signals it routes: ``EXTI0`` to ``EXTI15``.
    """

    def __init__(self, name: str, base: int, services: Services, pins: Pins, signals: Signals) -> None:
        super().__init__(name, base, services)
        self._pins = pins
        self._signals = signals

    def reset(self) -> None:
        """Every EXTI line goes to port A."""
        super().reset()
        for line in range(16):
            self._signals.route(f"EXTI{line}", f"PA{line}")

    def write_EXTICR1(self, value: int) -> None:
        """Choose the ports of lines 0 to 3."""
        self._choose_ports(0, value)

    def write_EXTICR2(self, value: int) -> None:
        """Choose the ports of lines 4 to 7."""
        self._choose_ports(4, value)

    def write_EXTICR3(self, value: int) -> None:
        """Choose the ports of lines 8 to 11."""
        self._choose_ports(8, value)

    def write_EXTICR4(self, value: int) -> None:
        """Choose the ports of lines 12 to 15."""
        self._choose_ports(12, value)

    def _choose_ports(self, first: int, value: int) -> None:
        self[_FIRST + first] = value
        for index in range(4):
            port, line = value >> 4 * index & 0xF, first + index
            pin = f"P{_PORTS[port]}{line}" if port < len(_PORTS) else ""
            self._signals.route(f"EXTI{line}", pin if pin in self._pins else None)
