"""How far Thumb code runs straight ahead without a chance of changing an interrupt mask.

While an interrupt is pending that only PRIMASK, BASEPRI or FAULTMASK hold back, it has to be taken at the first
instruction boundary where the mask is gone. Masks change in CPS and MSR alone (and in exceptions, where the engine
stops by itself), so everything else may run in one slice, up to the next instruction that is one of these or may
go elsewhere (encodings: DDI0403 section A5).
"""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["straight_run"]

_NOP = 0xBF00


def straight_run(half: Callable[[int], int], pc: int, limit: int) -> int:
    """Return how many instructions from `pc` on, up to `limit`, neither branch nor change a mask.

    Args:
        half: returns the half-word at an address.
        pc: address of the first instruction.
        limit: to look at no more instructions than that.
    """
    count = 0
    while count < limit:
        first = half(pc)
        if first >> 11 in (0b11101, 0b11110, 0b11111):
            if _wide_ends(first, half(pc + 2)):
                break
            pc += 4
        else:
            if _narrow_ends(first):
                break
            pc += 2
        count += 1
    return count


def _narrow_ends(half: int) -> bool:
    """Say whether a 16-bit instruction may branch, trap or change a mask."""
    top = half >> 8
    if top in (0x44, 0x46):  # ADD, MOV with high registers
        return half & 0x87 == 0x87
    if top == 0xBF:  # IT and hints
        return half != _NOP
    return (
        0xD0 <= top <= 0xE7  # conditional branch, UDF, SVC, branch
        or top in (0x47, 0xB6, 0xBD, 0xBE)  # BX and BLX; CPS; POP with PC; BKPT
        or top & 0xF5 == 0xB1  # CBZ, CBNZ
    )


def _wide_ends(first: int, second: int) -> bool:
    """Say whether a 32-bit instruction may branch, trap or change a mask."""
    if first >> 11 == 0b11110 and second >> 15:  # branches and miscellaneous control
        return True
    if first >> 9 == 0b1110100 and second >> 15:  # LDM with PC, TBB, TBH; others of the group as well
        return True
    return first >> 9 == 0b1111100 and bool(first & 0x10) and second >> 12 == 0xF  # LDR into PC
