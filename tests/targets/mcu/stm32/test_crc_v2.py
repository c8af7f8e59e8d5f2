"""CRC with a programmable polynomial: published check values, and a division bit by bit."""

from __future__ import annotations

import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.bus import TakesParts
from targets.mcu.stm32.crc import Crc
from targets.mcu.testing import FakeChip, peek, poke

CHECK = b"123456789"
SIZE_BITS = {32: 0, 16: 1 << 3, 8: 2 << 3, 7: 3 << 3}
BY_BYTE, BY_HALF, BY_WORD, REV_OUT, RESET = 1 << 5, 2 << 5, 3 << 5, 1 << 7, 1


@pytest.fixture
def chip():
    return FakeChip()


@pytest.fixture
def crc(chip):
    return Crc(0x4002_3000, chip.services)


def by_bits(message, bits, size, polynomial, start):
    """Shift so many bits through a register with feedback."""
    register = start & (1 << size) - 1
    for position in reversed(range(bits)):
        feedback = register >> size - 1 ^ message >> position & 1
        register = register << 1 & (1 << size) - 1
        if feedback:
            register ^= polynomial & (1 << size) - 1
    return register


def feed(crc, message):
    for byte in message:
        crc.write_part(0, 1, byte)


def test_reset_values(crc):
    assert [peek(crc, name) for name in ("DR", "IDR", "CR", "INIT", "POL")] == [
        *(0xFFFF_FFFF, 0, 0),
        *(0xFFFF_FFFF, 0x04C1_1DB7),
    ]


def test_as_it_comes_it_is_that_of_other_families(crc):
    poke(crc, "DR", 0x1234_5678)
    assert peek(crc, "DR") == 0xDF8A_8A2B


@pytest.mark.parametrize(
    ("size", "polynomial", "start", "control", "result"),
    [
        (32, 0x04C1_1DB7, 0xFFFF_FFFF, 0, 0x0376_E6E7),  # CRC-32/MPEG-2
        (32, 0x04C1_1DB7, 0xFFFF_FFFF, BY_BYTE | REV_OUT, 0x340B_C6D9),  # CRC-32/JAMCRC
        (16, 0x1021, 0xFFFF, 0, 0x29B1),  # CRC-16/IBM-3740, known as CCITT-FALSE
        (16, 0x8005, 0xFFFF, BY_BYTE | REV_OUT, 0x4B37),  # CRC-16/MODBUS
        (8, 0x07, 0, 0, 0xF4),  # CRC-8/SMBUS
        (8, 0x31, 0, BY_BYTE | REV_OUT, 0xA1),  # CRC-8/MAXIM-DOW
        (7, 0x09, 0, 0, 0x75),  # CRC-7/MMC
    ],
)
def test_check_values(crc, size, polynomial, start, control, result):
    """Of the catalogue of parametrised CRC algorithms, for the message "123456789"."""
    poke(crc, "CR", SIZE_BITS[size] | control)
    poke(crc, "POL", polynomial)
    poke(crc, "INIT", start)
    feed(crc, CHECK)
    assert peek(crc, "DR") == result


def test_zlib(crc):
    poke(crc, "CR", BY_BYTE | REV_OUT | RESET)
    feed(crc, b"The quick brown fox")
    assert peek(crc, "DR") ^ 0xFFFF_FFFF == zlib.crc32(b"The quick brown fox")


@pytest.mark.parametrize(
    ("control", "seen"), [(BY_BYTE, 0x58D4_3CB2), (BY_HALF, 0xD458_B23C), (BY_WORD, 0xB23C_D458), (0, 0x1A2B_3C4D)]
)
def test_reversal_of_what_comes_in(crc, control, seen):
    """The examples of the manual."""
    poke(crc, "CR", control)
    poke(crc, "DR", 0x1A2B_3C4D)
    assert peek(crc, "DR") == by_bits(seen, 32, 32, 0x04C1_1DB7, 0xFFFF_FFFF)


def test_reversal_of_what_comes_out(crc):
    poke(crc, "INIT", 0x1122_3344)
    poke(crc, "CR", REV_OUT)
    assert peek(crc, "DR") == 0x22CC_4488


@given(
    size=st.sampled_from([7, 8, 16, 32]),
    polynomial=st.integers(0, 0x7FFF_FFFF).map(lambda value: 2 * value + 1),
    start=st.integers(0, 0xFFFF_FFFF),
    pieces=st.lists(st.tuples(st.sampled_from([1, 2, 4]), st.integers(0, 0xFFFF_FFFF)), max_size=6),
)
def test_any_polynomial(size, polynomial, start, pieces):
    crc = Crc(0x4002_3000, FakeChip().services)
    poke(crc, "CR", SIZE_BITS[size])
    poke(crc, "POL", polynomial)
    poke(crc, "INIT", start)
    expected = start & (1 << size) - 1
    for length, value in pieces:
        value &= (1 << 8 * length) - 1
        if length == 4:
            poke(crc, "DR", value)
        else:
            crc.write_part(0, length, value)
        expected = by_bits(value, 8 * length, size, polynomial, expected)
    assert peek(crc, "DR") == expected


def test_reset_keeps_the_settings(crc):
    poke(crc, "INIT", 0xABCD)
    poke(crc, "IDR", 0x1FF)
    poke(crc, "DR", 1)
    poke(crc, "CR", RESET | SIZE_BITS[16])
    assert peek(crc, "DR") == 0xABCD
    assert peek(crc, "CR") == SIZE_BITS[16]
    assert peek(crc, "IDR") == 0xFF


def test_lanes_of_other_registers(crc):
    assert isinstance(crc, TakesParts)
    crc.write_part(0x14, 2, 0x1021)
    assert peek(crc, "POL") == 0x04C1_1021
    assert crc.read_part(0x16, 1) == 0xC1


def test_an_even_polynomial_is_noted(crc, chip):
    poke(crc, "POL", 0x8004)
    assert chip.noted("misuse") == ["CRC_POL"]
