"""CRC-16/IBM-3740, also called CCITT-FALSE and AUTOSAR: polynomial 1021 hex, begins with FFFF hex, nothing reflected.

The firmware computes it over the payload alone and sends its high byte first (nhorro/ceai2020
rover_firmware/protocol/protocol.cpp, `calc_crc16` and `calc_crc_and_close_packet`).
"""

from __future__ import annotations

import binascii

__all__ = ["CRC_BYTES", "INITIAL", "crc16", "crc16_from"]

CRC_BYTES = 2
"""Bytes of a CRC on the wire."""

INITIAL = 0xFFFF
"""What a CRC begins with."""


def crc16(payload: bytes) -> int:
    """The CRC of a payload, 0..65535; FFFF hex of an empty one, 29B1 hex of the nine digits "123456789"."""
    return crc16_from(payload, INITIAL)


def crc16_from(payload: bytes, begin: int) -> int:
    """The CRC of a payload, 0..65535, begun with another value, 0..65535."""
    return binascii.crc_hqx(payload, begin)
