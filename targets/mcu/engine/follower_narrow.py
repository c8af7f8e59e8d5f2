"""The 16-bit instructions that `thumb` follows (DDI0403 section A5.2)."""

from __future__ import annotations

from collections.abc import Callable

from targets.mcu.engine.dataflow import Node
from targets.mcu.engine.follower import LR, PC, SP, C, Follower, NotUnderstood

__all__ = ["follow_narrow"]


def follow_narrow(code: Follower, half: int) -> None:
    """Follow a 16-bit instruction, not IT.

    Raises:
        NotUnderstood: see there.
    """
    for mask, pattern, follow in _INSTRUCTIONS:
        if half & mask == pattern:
            follow(code, half)
            return
    raise NotUnderstood(f"0x{half:04X}")


def _signed(value: int, bits: int) -> int:
    return (value ^ 1 << bits - 1) - (1 << bits - 1)


# --- shifts and sums


def _shift(code: Follower, half: int) -> None:
    kind, amount = half >> 11 & 3, half >> 6 & 31
    if kind and not amount:
        amount = 32
    result, carry = code.shifted(code.get(half >> 3 & 7), kind, amount)
    code.set(half & 7, result)
    if not code.in_block:
        code.set_nz(result)
        code.set_flag(C, carry)


def _add_or_sub(code: Follower, half: int) -> None:
    number = half >> 6 & 7
    b = code.constant(number) if half & 1 << 10 else code.get(number)
    operation = code.minus if half & 1 << 9 else code.plus
    code.set(half & 7, operation(code.get(half >> 3 & 7), b, flags=not code.in_block))


def _move(code: Follower, half: int) -> None:
    result = code.constant(half & 0xFF)
    code.set(half >> 8 & 7, result)
    if not code.in_block:
        code.set_nz(result)


def _compare(code: Follower, half: int) -> None:
    code.minus(code.get(half >> 8 & 7), code.constant(half & 0xFF), flags=True)


def _add_immediate(code: Follower, half: int) -> None:
    number = half >> 8 & 7
    code.set(number, code.plus(code.get(number), code.constant(half & 0xFF), flags=not code.in_block))


def _sub_immediate(code: Follower, half: int) -> None:
    number = half >> 8 & 7
    code.set(number, code.minus(code.get(number), code.constant(half & 0xFF), flags=not code.in_block))


# --- two registers


def _bitwise(code: Follower, half: int) -> None:
    operation, number = half >> 6 & 0xF, half & 7
    graph, a, b = code.graph, code.get(half & 7), code.get(half >> 3 & 7)
    result: Node = {
        0: lambda: graph.both(a, b),
        1: lambda: graph.differing(a, b),
        8: lambda: graph.both(a, b),
        12: lambda: graph.either(a, b),
        13: lambda: graph.mul(a, b),
        14: lambda: graph.both(a, graph.complement(b)),
        15: lambda: graph.complement(b),
    }[operation]()
    if operation != 8:
        code.set(number, result)
    if operation == 8 or not code.in_block:
        code.set_nz(result)


def _shift_by_register(code: Follower, half: int) -> None:
    kind = {2: 0, 3: 1, 4: 2, 7: 3}[half >> 6 & 0xF]
    result, carry = code.shifted(code.get(half & 7), kind, code.fixed_amount(half >> 3 & 7))
    code.set(half & 7, result)
    if not code.in_block:
        code.set_nz(result)
        code.set_flag(C, carry)


def _add_with_carry(code: Follower, half: int) -> None:
    a, b = code.get(half & 7), code.get(half >> 3 & 7)
    code.set(half & 7, code.plus(a, b, flags=not code.in_block, carry_in=code.at(C)))


def _sub_with_carry(code: Follower, half: int) -> None:
    a, b = code.get(half & 7), code.get(half >> 3 & 7)
    code.set(half & 7, code.minus_with_carry(a, b, flags=not code.in_block))


def _negate(code: Follower, half: int) -> None:
    code.set(half & 7, code.minus(code.constant(0), code.get(half >> 3 & 7), flags=not code.in_block))


def _compare_low(code: Follower, half: int) -> None:
    code.minus(code.get(half & 7), code.get(half >> 3 & 7), flags=True)


def _compare_negative(code: Follower, half: int) -> None:
    code.plus(code.get(half & 7), code.get(half >> 3 & 7), flags=True)


def _high(half: int) -> int:
    return half & 7 | half >> 4 & 8


def _add_high(code: Follower, half: int) -> None:
    number = _high(half)
    if number == PC:
        raise NotUnderstood("ADD to PC")
    code.set(number, code.plus(code.get(number), code.get(half >> 3 & 0xF), flags=False))


def _compare_high(code: Follower, half: int) -> None:
    code.minus(code.get(_high(half)), code.get(half >> 3 & 0xF), flags=True)


def _move_high(code: Follower, half: int) -> None:
    number, value = _high(half), code.get(half >> 3 & 0xF)
    if number == PC:
        value = code.graph.either(value, code.constant(1))
    code.set(number, value)


# --- loads and stores


def _load_literal(code: Follower, half: int) -> None:
    code.set(half >> 8 & 7, code.load(code.constant((code.pc + 4 & ~3) + 4 * (half & 0xFF)), 4))


_STORES = ((False, 4, False), (False, 2, False), (False, 1, False))
_BY_REGISTER = (*_STORES, (True, 1, True), (True, 4, False), (True, 2, False), (True, 1, False), (True, 2, True))


def _access_by_register(code: Follower, half: int) -> None:
    loads, size, signed = _BY_REGISTER[half >> 9 & 7]
    address = code.graph.add(code.get(half >> 3 & 7), code.get(half >> 6 & 7))
    if loads:
        code.set(half & 7, code.load(address, size, signed=signed))
    else:
        code.store(address, size, code.get(half & 7))


def _access(code: Follower, half: int) -> None:
    size = {0x6: 4, 0x7: 1, 0x8: 2}[half >> 12]
    address = code.graph.add(code.get(half >> 3 & 7), code.constant(size * (half >> 6 & 31)))
    if half & 1 << 11:
        code.set(half & 7, code.load(address, size))
    else:
        code.store(address, size, code.get(half & 7))


def _access_stack(code: Follower, half: int) -> None:
    address = code.graph.add(code.get(SP), code.constant(4 * (half & 0xFF)))
    if half & 1 << 11:
        code.set(half >> 8 & 7, code.load(address, 4))
    else:
        code.store(address, 4, code.get(half >> 8 & 7))


def _push(code: Follower, half: int) -> None:
    numbers = [number for number in range(8) if half >> number & 1] + ([LR] if half & 1 << 8 else [])
    bottom = code.graph.sub(code.get(SP), code.constant(4 * len(numbers)))
    for index, number in enumerate(numbers):
        code.store(code.graph.add(bottom, code.constant(4 * index)), 4, code.get(number))
    code.set(SP, bottom)


def _pop(code: Follower, half: int) -> None:
    numbers = [number for number in range(8) if half >> number & 1] + ([PC] if half & 1 << 8 else [])
    bottom = code.get(SP)
    code.set(SP, code.graph.add(bottom, code.constant(4 * len(numbers))))
    for index, number in enumerate(numbers):
        code.set(number, code.load(code.graph.add(bottom, code.constant(4 * index)), 4))


# --- addresses, extension


def _address(code: Follower, half: int) -> None:
    base = code.get(SP) if half & 1 << 11 else code.constant(code.pc + 4 & ~3)
    code.set(half >> 8 & 7, code.graph.add(base, code.constant(4 * (half & 0xFF))))


def _move_stack(code: Follower, half: int) -> None:
    offset = code.constant(4 * (half & 0x7F))
    move = code.graph.sub if half & 1 << 7 else code.graph.add
    code.set(SP, move(code.get(SP), offset))


def _extend(code: Follower, half: int) -> None:
    bits = 24 if half & 1 << 6 else 16
    value = code.graph.lsl(code.get(half >> 3 & 7), bits)
    code.set(half & 7, code.graph.lsr(value, bits) if half & 1 << 7 else code.graph.asr(value, bits))


def _nothing(_code: Follower, _half: int) -> None:
    pass


# --- branches


def _branch_exchange(code: Follower, half: int) -> None:
    number = half >> 3 & 0xF
    if half & 1 << 7:
        code.call_to(code.get(number))
    else:
        code.jump_to(code.get(number))


def _compare_and_branch(code: Follower, half: int) -> None:
    target = code.pc + 4 + ((half >> 3 & 31) << 1 | (half >> 9 & 1) << 6)
    zero = code.graph.equal(code.get(half & 7), code.constant(0))
    code.branch_if(code.graph.negated(zero) if half & 1 << 11 else zero, target)


def _branch_conditional(code: Follower, half: int) -> None:
    if half >> 8 & 0xF >= 14:
        raise NotUnderstood("SVC or UDF")
    code.branch_under(half >> 8 & 0xF, code.pc + 4 + 2 * _signed(half & 0xFF, 8))


def _branch(code: Follower, half: int) -> None:
    code.branch(code.pc + 4 + 2 * _signed(half & 0x7FF, 11))


_INSTRUCTIONS: tuple[tuple[int, int, Callable[[Follower, int], None]], ...] = (
    (0xF800, 0x1800, _add_or_sub),
    (0xE000, 0x0000, _shift),
    (0xF800, 0x2000, _move),
    (0xF800, 0x2800, _compare),
    (0xF800, 0x3000, _add_immediate),
    (0xF800, 0x3800, _sub_immediate),
    *((0xFFC0, 0x4000 | operation << 6, _bitwise) for operation in (0, 1, 8, 12, 13, 14, 15)),
    *((0xFFC0, 0x4000 | operation << 6, _shift_by_register) for operation in (2, 3, 4, 7)),
    (0xFFC0, 0x4140, _add_with_carry),
    (0xFFC0, 0x4180, _sub_with_carry),
    (0xFFC0, 0x4240, _negate),
    (0xFFC0, 0x4280, _compare_low),
    (0xFFC0, 0x42C0, _compare_negative),
    (0xFF00, 0x4400, _add_high),
    (0xFF00, 0x4500, _compare_high),
    (0xFF00, 0x4600, _move_high),
    (0xFF07, 0x4700, _branch_exchange),
    (0xF800, 0x4800, _load_literal),
    (0xF000, 0x5000, _access_by_register),
    *((0xF000, group << 12, _access) for group in (6, 7, 8)),
    (0xF000, 0x9000, _access_stack),
    (0xF000, 0xA000, _address),
    (0xFF00, 0xB000, _move_stack),
    (0xFF00, 0xB200, _extend),
    (0xF500, 0xB100, _compare_and_branch),
    (0xFE00, 0xB400, _push),
    (0xFE00, 0xBC00, _pop),
    (0xFFFF, 0xBF00, _nothing),
    (0xF000, 0xD000, _branch_conditional),
    (0xF800, 0xE000, _branch),
)
