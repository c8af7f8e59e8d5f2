"""EXTI of the STM32F1: 19 edge detectors for interrupts and events (RM0008 section 10.2 and 10.3).

Lines 0 to 15 listen to the inputs ``EXTI0`` to ``EXTI15``, which AFIO routes to pins. Lines 16 to 18 listen to the
signals ``EXTI16`` (PVD), ``EXTI17`` (RTC alarm) and ``EXTI18`` (USB wake-up) inside the chip.

An edge sets the pending bit only on a line that IMR unmasks: on one that only EMR does, "the pending bit corresponding
to the event line is not set" (RM0008 section 10.2.3). So a program that polls PR has to set IMR.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services

__all__ = ["LINES", "Exti"]

LINES = 19
_ALL = (1 << LINES) - 1

_IRQS: tuple[tuple[int, int], ...] = (
    (6, 1 << 0),
    (7, 1 << 1),
    (8, 1 << 2),
    (9, 1 << 3),
    (10, 1 << 4),
    (23, 0x03E0),
    (40, 0xFC00),
    (1, 1 << 16),
    (41, 1 << 17),
    (42, 1 << 18),
)
"""Interrupt number and the lines that share it (RM0008 table 63)."""


class Exti(Peripheral):
    """EXTI.

    Attributes:
        on_event: called at an edge of a line that EMR unmasks; the core takes it as an event for WFE.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("IMR", 0x00, writable=_ALL),
        Register("EMR", 0x04, writable=_ALL),
        Register("RTSR", 0x08, writable=_ALL),
        Register("FTSR", 0x0C, writable=_ALL),
        Register("SWIER", 0x10, writable=_ALL, note="a bit of a line that IMR masks sets no pending bit; it is noted"),
        Register("PR", 0x14, note="an edge sets no bit of a line that IMR masks"),
    )

    def __init__(self, name: str, base: int, services: Services) -> None:
        super().__init__(name, base, services)
        self.on_event: Callable[[], None] = lambda: None
        self._inputs = [services.input(f"EXTI{line}") for line in range(LINES)]
        self._irqs = [(services.irq(number), lines) for number, lines in _IRQS]
        self._listeners = [self._listener(line) for line in range(LINES)]

    def reset(self) -> None:
        """All lines masked, nothing pending."""
        super().reset()
        self._listen()
        self._drive_irqs()

    def write_IMR(self, value: int) -> None:
        """Unmask interrupts; what is pending already requests at once."""
        self[0x00] = value
        self._drive_irqs()

    def write_RTSR(self, value: int) -> None:
        """Choose the lines that take rising edges."""
        self[0x08] = value
        self._listen()

    def write_FTSR(self, value: int) -> None:
        """Choose the lines that take falling edges."""
        self[0x0C] = value
        self._listen()

    def write_SWIER(self, value: int) -> None:
        """A bit that goes from 0 to 1 acts like an edge of its line; bits are cleared by PR only."""
        rising = value & ~self[0x10]
        self[0x10] |= rising
        if rising & ~(self[0x00] | self[0x04]):
            text = "set for a line that IMR and EMR mask: no bit of PR, no interrupt, and a second write does nothing"
            self.services.notes.add("misuse", f"{self.name}_SWIER", text)
        self._triggered(rising)

    def write_PR(self, value: int) -> None:
        """Clear bits by writing 1, those of SWIER with them."""
        self[0x14] &= ~value
        self[0x10] &= ~value
        self._drive_irqs()

    def sends_events(self) -> bool:
        """Say whether an edge from outside could be an event for WFE."""
        return bool(self[0x04] & (self[0x08] | self[0x0C]))

    def _listener(self, line: int) -> Callable[[bool], None]:
        bit = 1 << line

        def changed(level: bool) -> None:
            if self[0x08 if level else 0x0C] & bit:
                self._triggered(bit)

        return changed

    def _listen(self) -> None:
        wanted = self[0x08] | self[0x0C]
        for line, signal in enumerate(self._inputs):
            listener = self._listeners[line] if wanted >> line & 1 else None
            if signal.on_change is not listener:
                signal.on_change = listener

    def _triggered(self, lines: int) -> None:
        if lines & self[0x00]:
            self[0x14] |= lines & self[0x00]
            self._drive_irqs()
        if lines & self[0x04]:
            self.on_event()

    def _drive_irqs(self) -> None:
        requests = self[0x14] & self[0x00]
        for line, lines in self._irqs:
            line.set(bool(requests & lines))
