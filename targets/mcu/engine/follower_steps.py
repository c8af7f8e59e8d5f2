"""Follows Thumb-2 code instruction by instruction; an IT block (DDI0403, A7.7.38) is one step."""

from __future__ import annotations

from targets.mcu.engine.follower import Follower, is_wide
from targets.mcu.engine.follower_narrow import follow_narrow
from targets.mcu.engine.follower_wide import follow_wide

__all__ = ["step"]


def step(follower: Follower) -> None:
    """Follow one instruction, or an IT block.

    Raises:
        NotUnderstood: the code does something that a graph of values cannot tell.
    """
    first = follower.half(follower.pc)
    if first >> 8 == 0xBF and first & 0xF:
        _follow_block(follower, first)
    else:
        _follow(follower, first)
    follower.instructions += 1


def _follow_block(follower: Follower, first: int) -> None:
    condition, mask = first >> 4 & 0xF, first & 0xF
    follower.pc += 2
    length = 4 - ((mask & -mask).bit_length() - 1)
    # from bit 4 down: the lowest bit of the condition for one instruction after the other
    ways = (condition & 1) << 4 | mask
    for index in range(length):
        half, came_from = follower.half(follower.pc), follower.pc
        after = came_from + (4 if is_wide(half) else 2)
        if follower.holds(condition & ~1 | ways >> 4 - index & 1):
            follower.in_block = True
            try:
                _follow(follower, half)
            finally:
                follower.in_block = False
            if follower.pc != after:
                return
        else:
            follower.pc = after


def _follow(follower: Follower, first: int) -> None:
    if is_wide(first):
        follower.next_pc = follower.pc + 4
        follow_wide(follower, first, follower.half(follower.pc + 2))
    else:
        follower.next_pc = follower.pc + 2
        follow_narrow(follower, first)
    follower.pc = follower.next_pc
