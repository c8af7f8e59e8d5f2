"""HSEM: 32 hardware semaphores (RM0433 section 10), for the one core that this chip has.

The CPU's bus master identifier is 3, and it is the only one that takes semaphores.
"""

from __future__ import annotations

from typing import ClassVar

from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services

__all__ = ["Hsem"]

IRQ = 125
COUNT = 32
RLR, C1IER, C1ICR, C1ISR, C1MISR, CR, KEYR = 0x80, 0x100, 0x104, 0x108, 0x10C, 0x140, 0x144
PROCESS, MASTER, LOCK, KEY = 0xFF, 0xF00, 1 << 31, 0xFFFF_0000
CPU = 3 << 8  # the identifier of this master, where MASTER has it (MASTERID 3: Cortex-M7)


class Hsem(Peripheral):
    """The semaphores: taken by a write and a read back, or by one read."""

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        *(Register(f"R{number}", 4 * number, 0, PROCESS | MASTER | LOCK) for number in range(COUNT)),
        *(Register(f"RLR{number}", RLR + 4 * number, 0, 0) for number in range(COUNT)),
        Register("C1IER", C1IER, 0),
        Register("C1ICR", C1ICR, 0),
        Register("C1ISR", C1ISR, 0, 0),
        Register("C1MISR", C1MISR, 0, 0),
        Register("CR", CR, 0, KEY | MASTER),
        Register("KEYR", KEYR, 0, KEY),
    )

    def __init__(self, base: int, services: Services) -> None:
        super().__init__("HSEM", base, services)
        self._irq = services.irq(IRQ)

    def reset(self) -> None:
        """All semaphores are free."""
        super().reset()
        self._drive()

    def read(self, offset: int) -> int:
        """Read the word at `offset`; a read of RLR takes a free semaphore for process 0."""
        if RLR <= offset < RLR + 4 * COUNT:
            number = offset - RLR
            if not self[number] & LOCK:
                self[number] = LOCK | CPU
            return self[number]
        if offset == C1MISR:
            return self[C1ISR] & self[C1IER]
        return 0 if offset in (C1ICR, CR) else super().read(offset)

    def write(self, offset: int, value: int) -> None:
        """Write the word at `offset`."""
        if offset < RLR:
            self._ask(offset, value)
        elif offset == C1ICR:
            self[C1ISR] &= ~value
            self._drive()
        elif offset == CR:
            self._clear(value)
        else:
            super().write(offset, value)
            self._drive()

    def _ask(self, offset: int, value: int) -> None:
        """Take a free semaphore, or release it by who took it: the same process of the same master."""
        owner = value & (PROCESS | MASTER)
        if value & LOCK:
            if not self[offset] & LOCK and value & MASTER == CPU:
                self[offset] = LOCK | owner
        elif self[offset] == LOCK | owner:
            self._release(offset)

    def _clear(self, value: int) -> None:
        """Release all that a master has taken, with the key of KEYR."""
        if value & KEY != self[KEYR] & KEY:
            return
        for offset in range(0, RLR, 4):
            if self[offset] & LOCK and self[offset] & MASTER == value & MASTER:
                self._release(offset)

    def _release(self, offset: int) -> None:
        self[offset] = 0
        self[C1ISR] |= 1 << offset // 4
        self._drive()

    def _drive(self) -> None:
        self._irq.set(bool(self[C1ISR] & self[C1IER]))
