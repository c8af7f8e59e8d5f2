"""Encodings of branches (DDI0403 section A7.7.12); distances count in bytes from the instruction itself."""

from __future__ import annotations


def branch(distance: int) -> tuple[int, ...]:
    return (0xE000 | _field(distance, 12),)


def branch_if(condition: int, distance: int) -> tuple[int, ...]:
    return (0xD000 | condition << 8 | _field(distance, 9),)


def branch_if_zero(register: int, nonzero: int, distance: int) -> tuple[int, ...]:
    offset = distance - 4
    assert 0 <= offset < 128
    return (0xB100 | nonzero << 11 | (offset >> 6) << 9 | (offset >> 1 & 0x1F) << 3 | register,)


def branch_if_wide(condition: int, distance: int) -> tuple[int, ...]:
    field = _field(distance, 21)
    j1, j2, sign = field >> 17 & 1, field >> 18 & 1, field >> 19 & 1
    return 0xF000 | sign << 10 | condition << 6 | field >> 11 & 0x3F, 0x8000 | j1 << 13 | j2 << 11 | field & 0x7FF


def branch_wide(distance: int) -> tuple[int, ...]:
    field = _field(distance, 25)
    sign = field >> 23 & 1
    j1, j2 = field >> 22 & 1 ^ sign ^ 1, field >> 21 & 1 ^ sign ^ 1
    return 0xF000 | sign << 10 | field >> 11 & 0x3FF, 0x9000 | j1 << 13 | j2 << 11 | field & 0x7FF


def branch_link(distance: int) -> tuple[int, ...]:
    first, second = branch_wide(distance)
    return first, second | 0x4000


def _field(distance: int, bits: int) -> int:
    """Return half of what is added to PC, in so many bits less one."""
    offset = distance - 4
    assert -(1 << bits - 1) <= offset < 1 << bits - 1
    return offset >> 1 & (1 << bits - 1) - 1
