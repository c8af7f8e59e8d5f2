"""CRC-16/IBM-3740, also called CCITT-FALSE and AUTOSAR: polynomial 1021 hex, begins with FFFF hex, nothing reflected.

The firmware computes it over the payload alone and sends its high byte first (nhorro/ceai2020
rover_firmware/protocol/protocol.cpp, `calc_crc16` and `calc_crc_and_close_packet`). Here it comes from crcmod where
that was built with its C extension; without, crcmod is pure Python and slow, and `binascii.crc_hqx`, which is C always
and the same polynomial, takes its place. `crc_source()` says which; the tests hold both against a third, bit by bit.
"""

from __future__ import annotations

import binascii
import importlib
from collections.abc import Callable

__all__ = ["CRC_BYTES", "crc16", "crc_source"]

CRC_BYTES = 2
"""Bytes of a CRC on the wire."""

_INITIAL = 0xFFFF
_POLYNOMIAL = 0x11021  # as crcmod wants it, with its leading bit


def _crc_hqx(payload: bytes) -> int:
    return binascii.crc_hqx(payload, _INITIAL)


def _choose() -> tuple[str, Callable[[bytes], int]]:
    """The name of the implementation and the function, the same whichever it is."""
    try:
        crcmod = importlib.import_module("crcmod.crcmod")
    except ImportError:
        return "binascii", _crc_hqx
    if not crcmod._usingExtension:  # noqa: SLF001 - crcmod says it nowhere else
        return "binascii", _crc_hqx
    return "crcmod", crcmod.mkCrcFun(_POLYNOMIAL, initCrc=_INITIAL, rev=False, xorOut=0)


_NAME, _FUNCTION = _choose()


def crc16(payload: bytes) -> int:
    """The CRC of a payload, 0..65535; FFFF hex of an empty one, 29B1 hex of the nine digits "123456789"."""
    return _FUNCTION(payload)


def crc_source() -> str:
    """Which implementation is in use: ``"crcmod"`` with its C extension, or ``"binascii"`` of the standard library."""
    return _NAME
