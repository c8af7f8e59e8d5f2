"""The sectors of the flash of an STM32F76x, as one bank or as two (RM0410 section 3.3.1, tables 3 to 6)."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Sector", "sectors_of"]

_KB = 1024
_BANK_2 = 16  # bit 4 of SNB


@dataclass(frozen=True, slots=True)
class Sector:
    """A part of the flash that is erased as one.

    Attributes:
        number: as SNB has it.
        index: counted from 0 over both banks.
        offset: of its first byte.
        size: bytes.
        bank: 0 or 1.
    """

    number: int
    index: int
    offset: int
    size: int
    bank: int


def sectors_of(flash_bytes: int, *, dual_bank: bool) -> tuple[Sector, ...]:
    """Return the sectors in order: four small ones, one four times as large, then of eight times the size each."""
    banks, small = (2, 16 * _KB) if dual_bank else (1, 32 * _KB)
    bank_bytes = flash_bytes // banks
    found: list[Sector] = []
    for bank in range(banks):
        number, offset = _BANK_2 * bank, bank_bytes * bank
        while offset < bank_bytes * (bank + 1):
            size = small * (1 if number % _BANK_2 < 4 else 4 if number % _BANK_2 == 4 else 8)
            found.append(Sector(number, len(found), offset, size, bank))
            number, offset = number + 1, offset + size
    return tuple(found)
