"""How many cycles each instruction of a Cortex-M7 takes if nothing is issued beside it. All of it is a choice.

Arm publishes no such table for this core: it issues pairs, predicts branches, and has caches in front of the memories.
So this is how it runs at its slowest from its caches: loads and stores of one word take a cycle, of several words half
as many (the paths to memory are 64 bits wide), a branch taken one more, divisions and roots what the radix of the
dividers suggests; wait states of the flash never show. The timing model ``flat`` is nearer to what programs take.
"""

from __future__ import annotations

from targets.mcu.engine.opcode_cycles import Cost, is_wide
from targets.mcu.engine.opcode_cycles import cost_of as cost_of_m3

__all__ = ["DIVIDE", "REFILL", "cost_of"]

REFILL = 1
DIVIDE = 7
_DIVIDE_SINGLE, _DIVIDE_DOUBLE = 14, 28  # and square roots
_DOUBLE_PRODUCT, _SPECIAL = 3, 2


def cost_of(first: int, second: int) -> Cost:
    """Return what the instruction in these half-words takes; `second` counts only for one of 32 bits."""
    if is_wide(first) and first & 0xEC00 == 0xEC00:
        return Cost(4, _floating_point(first, second))
    cost = cost_of_m3(first, second)
    return Cost(cost.size, _cycles(first, second), it_length=cost.it_length)


def _cycles(first: int, second: int) -> int:
    if not is_wide(first):
        return _narrow(first)
    if first >> 9 == 0b1110100 and not first & 0x40:  # LDM, STM
        return _pairs(second.bit_count())
    if first & 0xFFD0 == 0xFB90:  # SDIV, UDIV
        return DIVIDE
    if first >> 5 in (0b11110011100, 0b11110011111) and second >> 14 == 0b10 and not second & 0x1000:  # MSR, MRS
        return _SPECIAL
    return 1


def _narrow(half: int) -> int:
    top = half >> 8
    if top in (0xB4, 0xB5, 0xBC, 0xBD):  # PUSH, POP
        return _pairs((half & 0x1FF).bit_count())
    if 0xC0 <= top <= 0xCF:  # STM, LDM
        return _pairs((half & 0xFF).bit_count())
    return _SPECIAL if top == 0xB6 else 1


def _floating_point(first: int, second: int) -> int:
    double = second & 0x100
    if first >> 9 == 0b1110110:
        several = first & 0x0120 != 0x0100 and first & 0x01A0  # not VLDR, VSTR, or a transfer of a pair
        return _pairs(second & 0xFF) if several else 1
    if first & 0xFFB0 == 0xEE80 or (first & 0xFFBF == 0xEEB1 and second & 0xC0 == 0xC0):  # VDIV, VSQRT
        return _DIVIDE_DOUBLE if double else _DIVIDE_SINGLE
    if double and first & 0xFF00 == 0xEE00 and (not first & 0x80 or first & 0xB0 in (0x90, 0xA0)) and not second & 0x10:
        return 1 if first & 0xB0 == 0x30 else _DOUBLE_PRODUCT  # VADD, VSUB; products
    return 1


def _pairs(words: int) -> int:
    return max(1, (words + 1) // 2)
