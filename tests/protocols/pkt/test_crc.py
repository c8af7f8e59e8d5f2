"""The CRC against two others, one of them bit by bit."""

from __future__ import annotations

import binascii
import importlib
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols.pkt.crc import crc16, crc_source


def bit_by_bit(payload):
    """The definition of CRC-16/IBM-3740 in the catalogue of parametrised CRC algorithms, nothing else."""
    register = 0xFFFF
    for byte in payload:
        for bit in range(7, -1, -1):
            carry = register >> 15 ^ byte >> bit & 1
            register = (register << 1 & 0xFFFF) ^ (0x1021 if carry else 0)
    return register


@pytest.mark.parametrize(
    ("payload", "expected"),
    [(b"", 0xFFFF), (b"123456789", 0x29B1), (b"\x00", 0xE1F0), (b"\x01", 0xF1D1), (b"\x01\x00\x00", 0xFBAC)],
)
def test_known_values(payload, expected):
    assert crc16(payload) == bit_by_bit(payload) == expected


@given(st.binary(max_size=200))
def test_equal_to_its_definition_and_to_the_standard_librarys(payload):
    assert crc16(payload) == bit_by_bit(payload) == binascii.crc_hqx(payload, 0xFFFF)


@given(st.binary(max_size=96))
def test_payload_and_crc_together_leave_nothing(payload):
    assert crc16(payload + crc16(payload).to_bytes(2, "big")) == 0


@given(st.binary(min_size=1, max_size=96), st.integers(0, 8 * 96 - 1))
def test_every_single_bit_error_is_seen(payload, bit):
    bit %= 8 * len(payload)
    damaged = bytearray(payload)
    damaged[bit // 8] ^= 1 << bit % 8
    assert crc16(bytes(damaged)) != crc16(payload)


def test_it_says_which_implementation_it_is():
    assert crc_source() == ("crcmod" if importlib.import_module("crcmod.crcmod")._usingExtension else "binascii")


@pytest.mark.parametrize(
    "obstacle",
    [
        "sys.modules['crcmod.crcmod'] = None",
        "import importlib; importlib.import_module('crcmod.crcmod')._usingExtension = False",
    ],
    ids=["without crcmod", "without its extension"],
)
def test_without_the_c_extension_the_standard_library_takes_its_place(obstacle):
    code = f"import sys; {obstacle}; from protocols.pkt import crc; print(crc.crc_source(), crc.crc16(b'123456789'))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["binascii", str(0x29B1)]
