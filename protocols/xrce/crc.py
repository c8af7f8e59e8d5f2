"""CRC-16/ARC: polynomial 8005 hex, reflected (A001), begins with 0, nothing turned over at the end.

The specification (OMG DDS-XRCE 1.0, Annex C.1.1.6) wants the CRC of RFC 1662 over addresses, length and payload. This
is what clients and agents in use have instead, that of Micro XRCE-DDS (eProsima/Micro-XRCE-DDS-Client,
src/c/profile/transport/stream_framing/stream_framing_protocol.c, `uxr_update_crc`): over the payload alone, before
escaping, low byte first on the wire.
"""

from __future__ import annotations

__all__ = ["CRC_BYTES", "crc16"]

CRC_BYTES = 2
"""Bytes of a CRC on the wire, before escaping."""

_POLYNOMIAL = 0xA001


def _entry(index: int) -> int:
    for _ in range(8):
        index = index >> 1 ^ (_POLYNOMIAL if index & 1 else 0)
    return index


_TABLE = tuple(_entry(index) for index in range(256))


def crc16(payload: bytes) -> int:
    """The CRC of a payload, 0..65535; 0 of an empty one, BB3D hex of the nine digits "123456789"."""
    crc = 0
    for byte in payload:
        crc = crc >> 8 ^ _TABLE[(crc ^ byte) & 0xFF]
    return crc
