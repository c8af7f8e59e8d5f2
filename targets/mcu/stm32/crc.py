"""CRC with a programmable polynomial (RM0410 section 12; the same in F0, F3, L4, G4 and H7): 7, 8, 16 or 32 bits.

Data come as words, half-words or bytes, most significant bit first, each perhaps reversed first. Choices where the
manual is silent: REV_OUT reverses the bits that the polynomial has; an even polynomial computes what it says, and is
noted; a byte or half-word counts the same in whichever lanes of DR it is written.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from dataclasses import replace
from typing import ClassVar

from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services

__all__ = ["Crc"]

DR, IDR, CR, INIT, POL = 0x00, 0x04, 0x08, 0x10, 0x14
RESET, POLYSIZE, REV_IN, REV_OUT = 1 << 0, 3 << 3, 3 << 5, 1 << 7
WORD = 0xFFFF_FFFF
SIZES = (32, 16, 8, 7)  # by POLYSIZE
_UNITS = (0, 8, 16, 32)  # by REV_IN: in which the bits are reversed


class Crc(Peripheral):
    """The CRC unit. A word takes silicon four cycles, for which it stalls the next access; here it takes none.

    Args:
        base: address.
        services: what the chip offers.
        data_bits: of IDR: 8, or 32 on the STM32H7.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("DR", DR, WORD),
        Register("IDR", IDR, 0, 0xFF),
        Register("CR", CR, 0, RESET | POLYSIZE | REV_IN | REV_OUT),
        Register("INIT", INIT, WORD),
        Register("POL", POL, 0x04C1_1DB7),
    )

    def __init__(self, base: int, services: Services, *, data_bits: int = 8) -> None:
        self._data_bits = data_bits
        super().__init__("CRC", base, services)

    def registers_of(self) -> Iterable[Register]:
        """Return the registers, IDR with the bits that it has."""
        for register in self.REGISTERS:
            yield replace(register, writable=(1 << self._data_bits) - 1) if register.name == "IDR" else register

    # --- registers

    def read_part(self, offset: int, size: int) -> int:
        """Read 1 or 2 bytes."""
        return self.read(offset & ~3) >> 8 * (offset & 3) & (1 << 8 * size) - 1

    def write_part(self, offset: int, size: int, value: int) -> None:
        """Write 1 or 2 bytes: to DR that much of the message, elsewhere only these lanes."""
        if offset & ~3 == DR:
            self._take(value, 8 * size)
            return
        shift, mask = 8 * (offset & 3), (1 << 8 * size) - 1
        kept = self[offset & ~3] if offset & ~3 in self.registers else 0
        self.write(offset & ~3, kept & ~(mask << shift) | (value & mask) << shift)

    def read_DR(self) -> int:
        """Return the remainder so far."""
        return _reversed(self[DR], self._size, self._size) if self[CR] & REV_OUT else self[DR]

    def write_DR(self, value: int) -> None:
        """Take one more word."""
        self._take(value, 32)

    def write_CR(self, value: int) -> None:
        """Choose size and reversal; RESET begins anew and reads 0; IDR stays."""
        self[CR] = value & ~RESET
        if value & RESET:
            self._begin()

    def write_INIT(self, value: int) -> None:
        """Set what a computation begins with, and begin one."""
        self[INIT] = value
        self._begin()

    def write_POL(self, value: int) -> None:
        """Set the polynomial."""
        if not value & 1:
            self.note("misuse", "POL", "an even polynomial is not supported")
        self[POL] = value

    # --- computing

    @property
    def _size(self) -> int:
        return SIZES[(self[CR] & POLYSIZE) >> 3]

    def _begin(self) -> None:
        self[DR] = self[INIT] & (1 << self._size) - 1

    def _take(self, data: int, bits: int) -> None:
        """Take so many bits of the message."""
        unit = min(_UNITS[(self[CR] & REV_IN) >> 5], bits)
        if unit:
            data = _reversed(data, bits, unit)
        size = self._size
        table = _table(self[POL] << 32 - size & WORD)
        rest = self[DR] << 32 - size & WORD
        for byte in data.to_bytes(bits // 8, "big"):
            rest = (rest << 8 & WORD) ^ table[rest >> 24 ^ byte]
        self[DR] = rest >> 32 - size


def _reversed(value: int, bits: int, unit: int) -> int:
    """Return `bits` of a value, with those of each unit the other way round."""
    result = 0
    for start in range(0, bits, unit):
        part = value >> start & (1 << unit) - 1
        result |= int(f"{part:0{unit}b}"[::-1], 2) << start
    return result


@functools.lru_cache(maxsize=8)
def _table(polynomial: int) -> tuple[int, ...]:
    """Return the remainder of each byte by a polynomial whose highest term but one is in bit 31."""
    entries = []
    for byte in range(256):
        rest = byte << 24
        for _ in range(8):
            rest = (rest << 1 ^ polynomial if rest & 1 << 31 else rest << 1) & WORD
        entries.append(rest)
    return tuple(entries)
