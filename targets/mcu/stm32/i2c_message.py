"""What CR2 says of a message, and the packet error code over its bytes (RM0410 sections 33.4.9 and 33.4.12)."""

from __future__ import annotations

from targets.mcu.stm32.i2c_registers import ADD10, HEAD10R, RD_WRN

__all__ = ["address_bytes", "count", "crc8", "header"]

_HEADER = 0xF0


def count(control: int) -> int:
    """Return NBYTES."""
    return control >> 16 & 0xFF


def header(control: int) -> int:
    """Return the first byte of a 10-bit address, for writing."""
    return _HEADER | control >> 7 & 6


def address_bytes(control: int) -> list[int]:
    """Return the bytes that follow START, as far as they come before a repeated one."""
    reading = bool(control & RD_WRN)
    if not control & ADD10:
        return [control & 0xFE | int(reading)]
    if reading and control & HEAD10R:
        return [header(control) | 1]
    return [header(control), control & 0xFF]


def crc8(value: int) -> int:
    """Divide by x^8 + x^2 + x + 1 (RM0410 section 33.4.12)."""
    for _ in range(8):
        value = value << 1 ^ (0x107 if value & 0x80 else 0)
    return value & 0xFF
