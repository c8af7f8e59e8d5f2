"""Random instructions of those that `targets.mcu.engine.follower` follows, without branches."""

from __future__ import annotations

from hypothesis import strategies as st

BASE_REGISTER, BASE = 6, 0x2000_0400  # no instruction here writes it,
OTHER_REGISTER = 7  # nor this
# Letters are free bits; d, t and u are registers that are written, which leave those two alone.
NARROW = [
    *("00000 iiiii mmm ddd", "00001 iiiii mmm ddd", "00010 iiiii mmm ddd", "00011oo iii nnn ddd"),
    *("001oo ddd iiiiiiii", "010000 oooo mmm ddd"),
    *("01000100 0 10mm ddd", "01000100 0 0mmm ddd", "01000101 0 10mm nnn", "01000110 0 10mm ddd"),
    *("01000110 1 0mmm 0dd", "10110010 oo mmm ddd", "10111111 00000000", "1010 p ddd iiiiiiii"),
    *("0110l iiiii 110 ttt", "0111l iiiii 110 ttt", "1000l iiiii 110 ttt", "1001l ttt 00iiiiii", "01001 ttt iiiiiiii"),
]
_SUMS, _COMPARISONS = ("0000", "0001", "0010", "0011", "0100", "1000", "1010", "1011", "1101", "1110"), ("0000", "0100")
WIDE = [
    *(f"11110 i 0 {operation} s 0nnn 0 iii 0ddd 1iiiiiii" for operation in _SUMS),
    *(f"1110101 {operation} s 0nnn 0 iii 0ddd 1i tt 0mmm" for operation in _SUMS),
    *(f"11110 i 0 {operation} 1 0nnn 0 iii 1111 1iiiiiii" for operation in (*_COMPARISONS, "1000", "1101")),
    *(f"11110 i 0 001{invert} s 1111 0 iii 0ddd 1iiiiiii" for invert in "01"),
    *(f"1110101 001{invert} s 1111 0 iii 0ddd 1i kk 0mmm" for invert in "01"),
    *("11110 i 100000 0nnn 0 iii 0ddd iiiiiiii", "11110 i 101010 0nnn 0 iii 0ddd iiiiiiii"),
    *("11110 i 100100 iiii 0 iii 0ddd iiiiiiii", "11110 i 101100 iiii 0 iii 0ddd iiiiiiii"),
    *("11110 0 110100 0nnn 0 0ii 0ddd ii 00iiii", "11110 0 111100 0nnn 0 0ii 0ddd ii 00iiii"),
    *("11110 0 110110 0nnn 0 0ii 0ddd ii 01iiii", "11110 0 110110 1111 0 0ii 0ddd ii 01iiii"),
    *("11111010 0 kk s 0nnn 1111 0ddd 0000 0mmm", "11111010 0 00p 1111 1111 0ddd 10 rr 0mmm"),
    "11111010 0 10p 1111 1111 0ddd 10 rr 0mmm",
    *("11111011 0000 0nnn 1111 0ddd 0000 0mmm", "11111011 0000 0nnn 0aaa 0ddd 000o 0mmm"),
    *("11111011 1000 0nnn 00dd 1000 0000 0mmm", "11111011 1010 0nnn 1000 00dd 0000 0mmm"),
    *("11111011 1001 0nnn 1111 0ddd 1111 0mmm", "11111011 1011 0nnn 1111 0ddd 1111 0mmm"),
    *(f"11111000 1{size} l 0110 0ttt 0000 iiiiiiii" for size in ("00", "01", "10")),
    *(f"11111001 1{size} 1 0110 0ttt 0000 iiiiiiii" for size in ("00", "01")),
    *(f"11111000 0{size} l 0110 0ttt 1100 iiiiiiii" for size in ("00", "01", "10")),
    *("11101001 1101 0110 0ttt 10uu 00iiiiii", "11101001 0100 0110 0ttt 0uuu 00iiiiii"),
    *("11110011 10101111 10000000 00000000", "11110011 10111111 10001111 01011111"),
]
NARROW, WIDE = ([pattern.replace(" ", "") for pattern in patterns] for patterns in (NARROW, WIDE))


@st.composite
def instruction(draw, patterns):
    """Return the half-words of an instruction."""
    pattern = draw(st.sampled_from(patterns))
    free = {letter: draw(st.integers(0, (1 << pattern.count(letter)) - 1)) for letter in sorted(set(pattern) - {*"01"})}
    for letter in {*"dtu"} & {*free}:
        if free[letter] in (BASE_REGISTER, OTHER_REGISTER):
            free[letter] -= 2
    word = 0
    for place, bit in enumerate(pattern):
        if bit not in "01":
            bit = str(free[bit] >> pattern.count(bit, place + 1) & 1)
        word = word << 1 | int(bit)
    return (word >> 16, word & 0xFFFF) if len(pattern) == 32 else (word,)


@st.composite
def block(draw):
    """Return an IT block."""
    mask = draw(st.integers(1, 15))
    count = 4 - ((mask & -mask).bit_length() - 1)
    inner = [draw(instruction(NARROW + WIDE)) for _ in range(count)]
    return [(0xBF00 | draw(st.integers(0, 13)) << 4 | mask,), *inner]


def stretches(least=1, most=6):
    """Return a strategy for lists of instructions and IT blocks, each a list of tuples of half-words."""
    one = instruction(NARROW + WIDE).map(lambda halves: [halves])
    return st.lists(st.one_of(one, one, one, block()), min_size=least, max_size=most)
