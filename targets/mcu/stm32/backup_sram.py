"""The 4 KB of backup SRAM, as registers so that its gate and its write protection hold (RM0410 4.1.2, RM0433 6.4.4)."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services

__all__ = ["BackupSram"]

SIZE = 0x1000


class BackupSram(Peripheral):
    """Memory that a reset leaves alone; a reset of the backup domain, too (choice). A program cannot run from it.

    Args:
        base: address.
        services: what the chip offers.
        writable: says whether PWR_CR1.DBP opens the backup domain.
    """

    size = SIZE
    REGISTERS: ClassVar[tuple[Register, ...]] = (Register("SRAM", 0, note="1024 words; no program can run here"),)

    def __init__(self, base: int, services: Services, *, writable: Callable[[], bool]) -> None:
        super().__init__("BKPSRAM", base, services)
        self._memory = bytearray(SIZE)
        self._writable = writable

    def read(self, offset: int) -> int:
        """Return a word."""
        return self.read_part(offset, 4)

    def write(self, offset: int, value: int) -> None:
        """Keep a word."""
        self.write_part(offset, 4, value)

    def read_part(self, offset: int, size: int) -> int:
        """Return some bytes."""
        return int.from_bytes(self._memory[offset : offset + size], "little")

    def write_part(self, offset: int, size: int, value: int) -> None:
        """Keep some bytes, unless the backup domain is write-protected."""
        if not self._writable():
            self.note("misuse", "SRAM", "the backup domain is write-protected: PWR_CR1.DBP is not set")
            return
        self._memory[offset : offset + size] = value.to_bytes(size, "little")
