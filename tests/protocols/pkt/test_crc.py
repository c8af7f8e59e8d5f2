"""The CRC against two others, one of them bit by bit, one with tables."""

from __future__ import annotations

import crcmod
from hypothesis import given
from hypothesis import strategies as st

from protocols.pkt.crc import crc16
from tests.each import each

WITH_TABLES = crcmod.mkCrcFun(0x11021, initCrc=0xFFFF, rev=False, xorOut=0)


def bit_by_bit(payload):
    """The definition of CRC-16/IBM-3740 in the catalogue of parametrised CRC algorithms, nothing else."""
    register = 0xFFFF
    for byte in payload:
        for bit in range(7, -1, -1):
            carry = register >> 15 ^ byte >> bit & 1
            register = (register << 1 & 0xFFFF) ^ (0x1021 if carry else 0)
    return register


@each(
    ("payload", "expected"),
    [(b"", 0xFFFF), (b"123456789", 0x29B1), (b"\x00", 0xE1F0), (b"\x01", 0xF1D1), (b"\x01\x00\x00", 0xFBAC)],
)
def test_known_values(payload, expected):
    assert crc16(payload) == bit_by_bit(payload) == expected


@given(st.binary(max_size=200))
def test_equal_to_its_definition_and_to_another(payload):
    assert crc16(payload) == bit_by_bit(payload) == WITH_TABLES(payload)


@given(st.binary(max_size=96))
def test_payload_and_crc_together_leave_nothing(payload):
    assert crc16(payload + crc16(payload).to_bytes(2, "big")) == 0


@given(st.binary(min_size=1, max_size=96), st.integers(0, 8 * 96 - 1))
def test_every_single_bit_error_is_seen(payload, bit):
    bit %= 8 * len(payload)
    damaged = bytearray(payload)
    damaged[bit // 8] ^= 1 << bit % 8
    assert crc16(bytes(damaged)) != crc16(payload)
