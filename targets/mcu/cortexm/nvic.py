"""Registers of the NVIC (DDI0403 section B3.4): the view that firmware has of `Exceptions`.

Registers for interrupts that the chip does not have read as zero and ignore writes, up to the 240 of the architecture.
"""

from __future__ import annotations

from typing import ClassVar

from targets.mcu.cortexm.exceptions import Exceptions, Number
from targets.mcu.cortexm.ppb import LaneBlock
from targets.mcu.registers import Register
from targets.mcu.services import Services

__all__ = ["Nvic"]

_WORD = 0xFFFF_FFFF
_ISER, _ICER, _ISPR, _ICPR, _IABR, _IPR, _STIR = 0x100, 0x180, 0x200, 0x280, 0x300, 0x400, 0xF00
_SETS = {_ISER: "ISER", _ICER: "ICER", _ISPR: "ISPR", _ICPR: "ICPR", _IABR: "IABR"}
_IPR_WORDS = 60


def _registers() -> tuple[Register, ...]:
    sets = [Register(f"{name}{word}", base + 4 * word) for base, name in _SETS.items() for word in range(8)]
    priorities = [Register(f"IPR{word}", _IPR + 4 * word) for word in range(_IPR_WORDS)]
    return (*sets, *priorities, Register("STIR", _STIR))


class Nvic(LaneBlock):
    """Enables, pending and active states and priorities of the interrupts.

    Args:
        exceptions: what the registers show.
    """

    REGISTERS = _registers()
    ONES_ACT: ClassVar[frozenset[str]] = frozenset({f"{name}{word}" for name in _SETS.values() for word in range(8)})

    def __init__(self, base: int, services: Services, exceptions: Exceptions) -> None:
        super().__init__("NVIC", base, services)
        self._exceptions = exceptions
        self._irqs = (1 << exceptions.count) - (1 << Number.FIRST_IRQ)

    def read(self, offset: int) -> int:
        """Read the word at `offset`; there are no side effects."""
        if offset >= _STIR:
            return 0
        if offset >= _IPR:
            return self._priorities(offset - _IPR)
        exceptions = self._exceptions
        base, word = offset & ~0x7F, offset >> 2 & 0x1F
        if base == _IABR:
            numbers = exceptions.active
        else:
            numbers = exceptions.enabled if base < _ISPR else exceptions.pending
        return numbers >> Number.FIRST_IRQ + 32 * word & _WORD

    def write(self, offset: int, value: int) -> None:
        """Write the word at `offset`."""
        if offset >= _STIR:
            self._trigger(value & 0x1FF)
        elif offset >= _IPR:
            self._set_priorities(offset - _IPR, value)
        else:
            self._write_set(offset & ~0x7F, (value << Number.FIRST_IRQ + 32 * (offset >> 2 & 0x1F)) & self._irqs)

    def other_lanes(self, offset: int) -> int:
        """Return the word that a narrow write to `offset` is merged into."""
        return self.read(offset) if _IPR <= offset < _STIR else 0

    def _write_set(self, base: int, numbers: int) -> None:
        exceptions = self._exceptions
        if base == _ISER:
            exceptions.enable(numbers)
        elif base == _ICER:
            exceptions.disable(numbers)
        elif base == _ISPR:
            exceptions.pend(numbers)
        elif base == _ICPR:
            exceptions.unpend(numbers)

    def _priorities(self, first_irq: int) -> int:
        configured = self._exceptions.priorities[Number.FIRST_IRQ + first_irq : Number.FIRST_IRQ + first_irq + 4]
        return int.from_bytes(bytes(configured), "little")

    def _set_priorities(self, first_irq: int, value: int) -> None:
        exceptions = self._exceptions
        for lane in range(4):
            number = Number.FIRST_IRQ + first_irq + lane
            if number < exceptions.count:
                exceptions.set_priority(number, value >> 8 * lane & 0xFF)

    def _trigger(self, irq: int) -> None:
        exceptions = self._exceptions
        if Number.FIRST_IRQ + irq < exceptions.count:
            exceptions.pend(1 << Number.FIRST_IRQ + irq)
        else:
            self.note("misuse", "STIR", f"this chip has no interrupt {irq}")
