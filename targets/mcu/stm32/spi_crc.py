"""The CRC of an SPI interface, and bits the other way round (RM0008 section 25.3.6, RM0410 section 35.5.14)."""

from __future__ import annotations

__all__ = ["crc_of", "reversed_bits"]


def crc_of(crc: int, word: int, polynomial: int, bits: int, width: int | None = None) -> int:
    """Return a CRC after one more word.

    Args:
        crc: before it.
        word: which goes in with its highest bit first.
        polynomial: without the bit above its highest.
        bits: of the word.
        width: bits of the CRC; as many as the word has if it is None.
    """
    width = bits if width is None else width
    mask = (1 << width) - 1
    for bit in range(bits - 1, -1, -1):
        flips = (crc >> width - 1 ^ word >> bit) & 1
        crc = (crc << 1 ^ (polynomial if flips else 0)) & mask
    return crc


def reversed_bits(word: int, bits: int) -> int:
    """Return a word with its lowest bit as the highest."""
    return int(f"{word & (1 << bits) - 1:0{bits}b}"[::-1], 2)
