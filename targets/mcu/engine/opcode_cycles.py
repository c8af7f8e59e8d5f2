"""How many cycles each Thumb-2 instruction of a Cortex-M3 takes (Technical Reference Manual r2p1, table 3-1).

Where the manual gives a range, one number is taken, and that is a choice: a pipeline refill P of 1 to 3 cycles is 2; a
division of 2 to 12 is 7; UMULL and SMULL of 3 to 5 are 4, UMLAL and SMLAL of 4 to 7 are 6; MSR and CPS of 1 to 2 are 2.
Pairs of loads and stores that the core would pipeline are not looked at: each takes its 2 cycles.
"""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["REFILL", "Cost", "cost_of", "is_wide"]

REFILL = 2
DIVIDE, LONG_MULTIPLY, LONG_ACCUMULATE = 7, 4, 6


class Cost(NamedTuple):
    """What an instruction takes.

    Attributes:
        size: in bytes.
        cycles: without the refill of the pipeline that comes with every branch taken.
        literal: True if it loads relative to PC, which is a read of flash.
        it_length: instructions that an IT governs; 0 for everything else.
    """

    size: int
    cycles: int
    literal: bool = False
    it_length: int = 0


def is_wide(first: int) -> bool:
    """Say whether a half-word begins an instruction of 32 bits (DDI0403 section A5.1)."""
    return first >> 11 in (0b11101, 0b11110, 0b11111)


def cost_of(first: int, second: int) -> Cost:
    """Return what the instruction in these half-words takes; `second` counts only for one of 32 bits."""
    return _wide(first, second) if is_wide(first) else _narrow(first)


def _narrow(half: int) -> Cost:
    top = half >> 8
    if half >> 11 == 0b01001:  # LDR literal
        return Cost(2, 2, literal=True)
    if 0x50 <= top <= 0x9F:  # loads and stores of one register
        return Cost(2, 2)
    if top in (0xB4, 0xB5, 0xBC, 0xBD):  # PUSH, POP
        return Cost(2, 1 + (half & 0x1FF).bit_count())
    if 0xC0 <= top <= 0xCF:  # STM, LDM
        return Cost(2, 1 + (half & 0xFF).bit_count())
    if top == 0xB6:  # CPS
        return Cost(2, 2)
    if top == 0xBF and half & 0xF:  # IT
        return Cost(2, 1, it_length=4 - ((half & 0xF & -(half & 0xF)).bit_length() - 1))
    return Cost(2, 1)


def _wide(first: int, second: int) -> Cost:
    group = first >> 9
    if group == 0b1110100:
        return _multiple_or_dual(first, second)
    if group == 0b1111100:  # loads and stores of one register; byte 1111 as base is PC
        return Cost(4, 2, literal=first & 0xF == 0xF and bool(first & 0x10))
    if first >> 8 == 0xFB:
        return Cost(4, _multiply(first, second))
    if first >> 5 == 0b11110011100 and second >> 14 == 0b10 and not second & 0x1000:  # MSR
        return Cost(4, 2)
    if first >> 5 == 0b11110011111 and second >> 14 == 0b10 and not second & 0x1000:  # MRS
        return Cost(4, 2)
    return Cost(4, 1)


def _multiple_or_dual(first: int, second: int) -> Cost:
    if not first & 0x40:  # LDM, STM
        return Cost(4, 1 + second.bit_count())
    if first & 0xFFF0 == 0xE8D0 and second & 0xFFE0 == 0xF000:  # TBB, TBH
        return Cost(4, 2)
    if first & 0x0120:  # LDRD, STRD
        return Cost(4, 3, literal=first & 0x1F == 0x1F)
    return Cost(4, 2)  # exclusives


def _multiply(first: int, second: int) -> int:
    operation = first >> 4 & 0xF
    if operation < 8:  # MUL, MLA, MLS
        return 1 if second >> 12 == 0xF else 2
    if operation in (0b1001, 0b1011):  # SDIV, UDIV
        return DIVIDE
    return LONG_MULTIPLY if operation in (0b1000, 0b1010) else LONG_ACCUMULATE
