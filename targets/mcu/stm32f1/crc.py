"""CRC: the CRC-32 of Ethernet, word by word, most significant bit first, without reflection (RM0008 section 4)."""

from __future__ import annotations

from typing import ClassVar

from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services

__all__ = ["Crc"]

DR, IDR, CR = 0x00, 0x04, 0x08
POLYNOMIAL = 0x04C1_1DB7
WORD = 0xFFFF_FFFF


def _table() -> tuple[int, ...]:
    entries = []
    for byte in range(256):
        rest = byte << 24
        for _ in range(8):
            rest = (rest << 1 ^ POLYNOMIAL if rest & 1 << 31 else rest << 1) & WORD
        entries.append(rest)
    return tuple(entries)


TABLE = _table()


class Crc(Peripheral):
    """The CRC unit. A word takes silicon four cycles, for which it stalls the next access; here it takes none."""

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("DR", DR, WORD),
        Register("IDR", IDR, 0, 0xFF),
        Register("CR", CR, 0, 1),
    )

    def __init__(self, base: int, services: Services) -> None:
        super().__init__("CRC", base, services)

    def write_DR(self, value: int) -> None:
        """Take one more word."""
        rest = self[DR] ^ value
        for _ in range(4):
            rest = (rest << 8 & WORD) ^ TABLE[rest >> 24]
        self[DR] = rest

    def write_CR(self, value: int) -> None:
        """RESET begins anew and reads 0; IDR stays."""
        if value & 1:
            self[DR] = WORD
