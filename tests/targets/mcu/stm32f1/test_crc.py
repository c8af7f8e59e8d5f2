"""CRC against a bit by bit division by the polynomial of RM0008 section 4, and known values of silicon."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.stm32f1.crc import Crc
from targets.mcu.testing import FakeChip, peek, poke
from tests.each import each

WORDS = st.integers(0, 0xFFFF_FFFF)


def by_bits(words, start=0xFFFF_FFFF):
    """Shift the message through a register with feedback, bit by bit."""
    register = start
    for word in words:
        for position in reversed(range(32)):
            feedback = (register >> 31) ^ (word >> position & 1)
            register = (register << 1) & 0xFFFF_FFFF
            if feedback:
                register ^= 0x04C1_1DB7
    return register


def make():
    return Crc(0x4002_3000, FakeChip().services)


def test_reset_values():
    crc = make()
    assert [peek(crc, name) for name in ("DR", "IDR", "CR")] == [0xFFFF_FFFF, 0, 0]


@each(
    ("words", "result"),
    [
        ([0x0000_0000], 0xC704_DD7B),
        ([0x1234_5678], 0xDF8A_8A2B),
        ([0xFFFF_FFFF], 0x0000_0000),
    ],
)
def test_known_values(words, result):
    crc = make()
    for word in words:
        poke(crc, "DR", word)
    assert peek(crc, "DR") == result == by_bits(words)


@given(words=st.lists(WORDS, max_size=20))
def test_against_the_division_bit_by_bit(words):
    crc = make()
    for word in words:
        poke(crc, "DR", word)
    assert peek(crc, "DR") == by_bits(words)


def test_reset_leaves_the_independent_byte():
    crc = make()
    poke(crc, "DR", 1)
    poke(crc, "IDR", 0x1A5)
    poke(crc, "CR", 1)
    assert [peek(crc, name) for name in ("DR", "IDR", "CR")] == [0xFFFF_FFFF, 0xA5, 0]
