"""The CRC of an SPI interface, and bits the other way round (RM0008 section 25.3.6)."""

from __future__ import annotations

__all__ = ["crc_of", "reversed_bits"]


def crc_of(crc: int, word: int, polynomial: int, bits: int) -> int:
    """Return a CRC of 8 or 16 bits after one more word of as many bits, which goes in with its highest bit first."""
    mask = (1 << bits) - 1
    crc ^= word & mask
    for _ in range(bits):
        crc = (crc << 1 ^ (polynomial if crc >> bits - 1 else 0)) & mask
    return crc


def reversed_bits(word: int, bits: int) -> int:
    """Return a word with its lowest bit as the highest."""
    return int(f"{word & (1 << bits) - 1:0{bits}b}"[::-1], 2)
