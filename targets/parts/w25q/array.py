"""The cells of a W25Q flash: programming clears bits, erasing sets them, and a part of them may be protected.

Winbond W25Q64JV data sheet, revision K: sections 7.1 (block protection), 8.2.13 to 8.2.18.
"""

from __future__ import annotations

__all__ = ["PAGE_BYTES", "SECTOR_BYTES", "Array"]

PAGE_BYTES, SECTOR_BYTES = 256, 4096
_SEC, _TB = 1 << 6, 1 << 5


class Array:
    """See the module.

    Args:
        size: in bytes.

    Attributes:
        data: every byte.
    """

    def __init__(self, size: int) -> None:
        self.data = bytearray(b"\xff" * size)

    def program(self, address: int, data: bytes) -> None:
        """Clear bits of a page; of more than a page the last 256 bytes count, and its end goes on at its beginning."""
        page, offset = address - address % PAGE_BYTES, address % PAGE_BYTES
        skipped = max(len(data) - PAGE_BYTES, 0)
        for number, byte in enumerate(data[skipped:], skipped):
            self.data[page + (offset + number) % PAGE_BYTES] &= byte

    def erase(self, address: int, size: int) -> None:
        """Set all bits of the sector or block of that size in which an address is."""
        begin = address - address % size
        self.data[begin : begin + size] = b"\xff" * size

    def is_protected(self, address: int, size: int, status: int) -> bool:
        """Say whether any byte of a range must not be changed.

        Args:
            address: its beginning.
            size: of the range, in bytes.
            status: status register 1, with SEC, TB and BP2 to BP0.
        """
        level, full = status >> 2 & 7, len(self.data)
        if not level:
            return False
        if level == 7:
            return True
        kept = min(SECTOR_BYTES << level - 1, 8 * SECTOR_BYTES) if status & _SEC else full >> 7 - level
        begin = 0 if status & _TB else full - kept
        return address < begin + kept and begin < address + size
