"""ITSTATE: under which conditions the instruction in flight and those behind it are executed (DDI0403 section A7.3.2).

It is kept in xPSR, bits 7 to 2 in 15 to 10 and bits 1 and 0 in 26 and 25. Unicorn computes it when it translates and
does not have it at hand while a register is accessed, so it is read from the code then.
"""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["IT_BITS", "advanced", "it_state_at"]

IT_BITS = 0x0600_FC00
"""Where ITSTATE is in xPSR."""

_LONGEST = 14  # bytes from an IT to the last of its instructions: itself and three wide ones
_WIDE = 0b11101  # the five upper bits of the first half of a wide instruction, or more


def advanced(xpsr: int) -> int:
    """Return xPSR after the instruction that it stands before (``ITAdvance``)."""
    return xpsr & ~IT_BITS | _placed(_next(xpsr >> 8 & 0xFC | xpsr >> 25 & 3))


def it_state_at(half: Callable[[int], int], pc: int) -> int:
    """Return ITSTATE of the instruction at `pc`, which is executed, as bits of xPSR.

    Args:
        half: gives the half-word of memory at an address, 0 where there is none.
        pc: an address of an instruction.
    """
    for address in range(pc - 2, pc - 2 - _LONGEST, -2):
        code = half(address)
        if code >> 8 == 0xBF and code & 0xF and _begins_instruction(half, address):
            return _placed(_reached(half, address + 2, pc, code & 0xFF))
    return 0


def _reached(half: Callable[[int], int], address: int, pc: int, state: int) -> int:
    while address < pc and state:
        address += 4 if half(address) >> 11 >= _WIDE else 2
        state = _next(state)
    return state if address == pc else 0


def _begins_instruction(half: Callable[[int], int], address: int) -> bool:
    """Say whether a half-word is no second one: one that begins no wide instruction ends one: count from it."""
    before = address
    while half(before - 2) >> 11 >= _WIDE:
        before -= 2
    return (address - before) % 4 == 0


def _next(state: int) -> int:
    return state & 0xE0 | state << 1 & 0x1F if state & 7 else 0


def _placed(state: int) -> int:
    return (state & 3) << 25 | (state & 0xFC) << 8
