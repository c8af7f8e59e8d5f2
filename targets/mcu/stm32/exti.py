"""EXTI of the STM32F1 and STM32F7: edge detectors for interrupts and events (RM0008 sections 10.2, 10.3; RM0410 11).

Lines 9, 11 and 15 trigger converters, too, by the signals ``EXTI9_EDGE``, ``EXTI11_EDGE`` and ``EXTI15_EDGE``: at the
edges that RTSR and FTSR choose, whatever IMR and EMR say (choice: the manual is silent).

Lines 0 to 15 listen to the inputs ``EXTI0`` to ``EXTI15``, which AFIO or SYSCFG routes to pins. The others listen to
signals inside the chip, such as ``EXTI17`` (RTC alarm).

An edge sets the pending bit only on a line that IMR unmasks: on one that only EMR does, "the pending bit corresponding
to the event line is not set" (RM0008 section 10.2.3). So a program that polls PR has to set IMR.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import ClassVar

from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services

__all__ = ["STM32F1", "STM32F7", "Exti", "ExtiKind"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ExtiKind:
    """What a family has of it.

    Attributes:
        lines: how many lines.
        irqs: interrupt number and the lines that share it.
    """

    lines: int
    irqs: tuple[tuple[int, int], ...]


_OF_PINS = (
    (6, 1 << 0),
    (7, 1 << 1),
    (8, 1 << 2),
    (9, 1 << 3),
    (10, 1 << 4),
    (23, 0x03E0),
    (40, 0xFC00),
)
"""The same in all families."""

# RM0008 table 63: PVD, RTC alarm, USB wake-up.
STM32F1 = ExtiKind(lines=19, irqs=(*_OF_PINS, (1, 1 << 16), (41, 1 << 17), (42, 1 << 18)))

# RM0410 table 46 and section 11.3: PVD, RTC alarm, OTG FS wake-up, Ethernet wake-up, OTG HS wake-up, tamper and time
# stamp, RTC wake-up, LPTIM1, MDIO slave.
STM32F7 = ExtiKind(
    lines=25,
    irqs=(
        *_OF_PINS,
        (1, 1 << 16),
        (41, 1 << 17),
        (42, 1 << 18),
        (62, 1 << 19),
        (76, 1 << 20),
        (2, 1 << 21),
        (3, 1 << 22),
        (93, 1 << 23),
        (109, 1 << 24),
    ),
)


TRIGGERS = (9, 11, 15)
"""Lines that other peripherals take as triggers (RM0008 tables 69, 70 and 74)."""


class Exti(Peripheral):
    """EXTI.

    Args:
        name: ``EXTI``.
        base: address.
        services: what the chip offers.
        kind: its lines and interrupts.

    Attributes:
        on_event: called at an edge of a line that EMR unmasks; the core takes it as an event for WFE.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("IMR", 0x00),
        Register("EMR", 0x04),
        Register("RTSR", 0x08),
        Register("FTSR", 0x0C),
        Register("SWIER", 0x10, note="a bit of a line that IMR masks sets no pending bit; it is noted"),
        Register("PR", 0x14, note="an edge sets no bit of a line that IMR masks"),
    )

    def __init__(self, name: str, base: int, services: Services, kind: ExtiKind) -> None:
        self._lines = kind.lines
        super().__init__(name, base, services)
        self.on_event: Callable[[], None] = lambda: None
        self._inputs = [services.input(f"EXTI{line}") for line in range(kind.lines)]
        self._irqs = [(services.irq(number), lines) for number, lines in kind.irqs]
        self._triggers = {line: services.output(f"EXTI{line}_EDGE") for line in TRIGGERS}
        self._listeners = [self._listener(line) for line in range(kind.lines)]

    def registers_of(self) -> Iterable[Register]:
        """Return the registers, with the bits of the lines that there are."""
        for register in self.REGISTERS:
            yield register if register.name == "PR" else replace(register, writable=(1 << self._lines) - 1)

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
        for line, trigger in self._triggers.items():
            if lines >> line & 1:
                trigger.set(True)
                trigger.set(False)
        if lines & self[0x00]:
            self[0x14] |= lines & self[0x00]
            self._drive_irqs()
        if lines & self[0x04]:
            self.on_event()

    def _drive_irqs(self) -> None:
        requests = self[0x14] & self[0x00]
        for line, lines in self._irqs:
            line.set(bool(requests & lines))
