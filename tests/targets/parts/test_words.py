"""Numbers on three wires."""

from __future__ import annotations

from targets.parts.words import bits_of, signed, word_of
from tests.each import each

TABLE = {0b000: 0, 0b001: 1, 0b010: 2, 0b011: 3, 0b100: -4, 0b101: -3, 0b110: -2, 0b111: -1}
"""comm3 comm2 comm1 and the code (bachelor-thesis, Fig. 22)."""


def test_codes_are_twos_complement() -> None:
    assert {word: signed(word) for word in range(8)} == TABLE


@each("order", ["lsb-first", "msb-first"])
@each("word", range(8))
def test_levels_and_words_are_inverse(order, word) -> None:
    assert word_of(bits_of(word, order), order) == word


def test_the_orders_are_each_other_reversed() -> None:
    assert bits_of(1, "lsb-first") == (True, False, False) == bits_of(4, "msb-first")
    assert bits_of(4, "lsb-first") == (False, False, True) == bits_of(1, "msb-first")
    assert bits_of(5, "lsb-first") == bits_of(5, "msb-first") == (True, False, True)
    assert bits_of(8 + 1, "lsb-first") == bits_of(1, "lsb-first")
