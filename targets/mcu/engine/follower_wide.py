"""The 32-bit instructions that `thumb` follows (DDI0403 section A5.3)."""

from __future__ import annotations

from collections.abc import Callable

from targets.mcu.engine.dataflow import Node
from targets.mcu.engine.follower import PC, C, Follower, NotUnderstood

__all__ = ["expand", "follow_wide"]

_NOTHING = {0xF3AF_8000, 0xF3BF_8F4F, 0xF3BF_8F5F, 0xF3BF_8F6F}  # NOP, DSB, DMB, ISB


def follow_wide(code: Follower, first: int, second: int) -> None:
    """Follow a 32-bit instruction.

    Raises:
        NotUnderstood: see there.
    """
    word = first << 16 | second
    for mask, pattern, follow in _INSTRUCTIONS:
        if word & mask == pattern:
            follow(code, word)
            return
    raise NotUnderstood(f"0x{word:08X}")


def expand(immediate: int) -> int:
    """Return what the 12 bits of a modified immediate stand for (DDI0403 section A5.3.2)."""
    byte = immediate & 0xFF
    if immediate >> 10:
        value = 0x80 | immediate & 0x7F
        rotation = immediate >> 7
        return (value >> rotation | value << 32 - rotation) & 0xFFFF_FFFF
    return byte * (0x1, 0x1_0001, 0x100_0100, 0x101_0101)[immediate >> 8 & 3]


def _immediate(word: int) -> int:
    return (word >> 26 & 1) << 11 | (word >> 12 & 7) << 8 | word & 0xFF


def _signed(value: int, bits: int) -> int:
    return (value ^ 1 << bits - 1) - (1 << bits - 1)


def _checked(*numbers: int) -> None:
    if PC in numbers:
        raise NotUnderstood("PC as an operand")


# --- data processing


def _process(code: Follower, word: int, b: Node, carry: Node | None) -> None:
    """Do what the field `op` says with Rn and the second operand."""
    operation, flags = word >> 21 & 0xF, bool(word & 1 << 20)
    a_number, number = word >> 16 & 0xF, word >> 8 & 0xF
    silent = number == PC  # TST, TEQ, CMN, CMP
    if silent and not flags:
        raise NotUnderstood(f"0x{word:08X}")
    if operation in (8, 10, 11, 13, 14):
        _checked(a_number)
        result = _sum(code, operation, code.get(a_number), b, flags=flags)
    else:
        result = _logic(code, operation, a_number, b)
        if flags:
            code.set_nz(result)
            code.set_flag(C, carry)
    if not silent:
        code.set(number, result)


def _sum(code: Follower, operation: int, a: Node, b: Node, *, flags: bool) -> Node:
    if operation == 8:
        return code.plus(a, b, flags=flags)
    if operation == 10:
        return code.plus(a, b, flags=flags, carry_in=code.at(C))
    if operation == 11:
        return code.minus_with_carry(a, b, flags=flags)
    return code.minus(a, b, flags=flags) if operation == 13 else code.minus(b, a, flags=flags)


def _logic(code: Follower, operation: int, a_number: int, b: Node) -> Node:
    graph = code.graph
    if operation in (1, 3):  # BIC, ORN and MVN
        b = graph.complement(b)
    if operation in (2, 3) and a_number == PC:  # MOV, MVN
        return b
    _checked(a_number)
    combine = {0: graph.both, 1: graph.both, 2: graph.either, 3: graph.either, 4: graph.differing}.get(operation)
    if combine is None:
        raise NotUnderstood("data processing")
    return combine(code.get(a_number), b)


def _modified_immediate(code: Follower, word: int) -> None:
    immediate = _immediate(word)
    value = code.constant(expand(immediate))
    carry = code.graph.negative(value) if immediate >> 10 else None
    _process(code, word, value, carry)


def _shifted_register(code: Follower, word: int) -> None:
    _checked(word & 0xF)
    kind, amount = word >> 4 & 3, (word >> 12 & 7) << 2 | word >> 6 & 3
    if kind == 3 and not amount:
        raise NotUnderstood("RRX")
    if kind and not amount:
        amount = 32
    _process(code, word, *code.shifted(code.get(word & 0xF), kind, amount))


def _plain_sum(code: Follower, word: int) -> None:
    number = word >> 16 & 0xF
    offset = code.constant(_immediate(word))
    base = code.constant(code.pc + 4 & ~3) if number == PC else code.get(number)
    operation = code.graph.sub if word >> 21 & 0x5 == 0x5 else code.graph.add
    code.set(word >> 8 & 0xF, operation(base, offset))


def _move_half(code: Follower, word: int) -> None:
    half = code.constant((word >> 16 & 0xF) << 12 | _immediate(word))
    number = word >> 8 & 0xF
    if word & 1 << 23:  # MOVT
        kept = code.graph.both(code.get(number), code.constant(0xFFFF))
        half = code.graph.either(kept, code.graph.lsl(half, 16))
    code.set(number, half)


def _bit_field(code: Follower, word: int) -> None:
    """SBFX, UBFX, BFI and BFC."""
    graph, source, number = code.graph, word >> 16 & 0xF, word >> 8 & 0xF
    low, last = (word >> 12 & 7) << 2 | word >> 6 & 3, word & 31
    kind = word >> 21 & 7
    if kind == 3:
        mask = (1 << last - low + 1) - 1 << low
        new = code.constant(0) if source == PC else code.graph.lsl(code.get(source), low)
        kept = graph.both(code.get(number), code.constant(~mask))
        code.set(number, graph.either(kept, graph.both(new, code.constant(mask))))
        return
    unused = 31 - last
    top = graph.lsl(code.get(source), unused - low)
    code.set(number, graph.lsr(top, unused) if kind == 6 else graph.asr(top, unused))


def _shift_by_register(code: Follower, word: int) -> None:
    result, carry = code.shifted(code.get(word >> 16 & 0xF), word >> 21 & 3, code.fixed_amount(word & 0xF))
    code.set(word >> 8 & 0xF, result)
    if word & 1 << 20:
        code.set_nz(result)
        code.set_flag(C, carry)


def _extend(code: Follower, word: int) -> None:
    if word >> 16 & 0xF != PC:
        raise NotUnderstood("extend and add")
    graph, bits = code.graph, 24 if word & 1 << 22 else 16
    value = graph.lsl(graph.ror(code.get(word & 0xF), 8 * (word >> 4 & 3)), bits)
    code.set(word >> 8 & 0xF, graph.lsr(value, bits) if word & 1 << 20 else graph.asr(value, bits))


# --- multiplication and division


def _multiply(code: Follower, word: int) -> None:
    graph = code.graph
    product = graph.mul(code.get(word >> 16 & 0xF), code.get(word & 0xF))
    if word >> 12 & 0xF != PC:
        addend = code.get(word >> 12 & 0xF)
        product = graph.sub(addend, product) if word & 1 << 4 else graph.add(addend, product)
    elif word & 1 << 4:
        raise NotUnderstood("MLS")
    code.set(word >> 8 & 0xF, product)


def _multiply_long(code: Follower, word: int) -> None:
    graph, a, b = code.graph, code.get(word >> 16 & 0xF), code.get(word & 0xF)
    high = graph.mul_high(a, b)
    if not word & 1 << 21:  # SMULL
        for one, other in ((a, b), (b, a)):
            high = graph.sub(high, graph.both(graph.asr(one, 31), other))
    code.set(word >> 12 & 0xF, graph.mul(a, b))
    code.set(word >> 8 & 0xF, high)


def _divide(code: Follower, word: int) -> None:
    signed = not word & 1 << 21
    code.set(word >> 8 & 0xF, code.divided(code.get(word >> 16 & 0xF), code.get(word & 0xF), signed=signed))


# --- loads and stores


def _access(code: Follower, word: int) -> None:
    """Load or store a register, in all its addressing modes."""
    size = 1 << (word >> 21 & 3)
    base_number, number = word >> 16 & 0xF, word >> 12 & 0xF
    if size > 4 or (number == PC and size < 4):
        raise NotUnderstood(f"0x{word:08X}")
    base, offset, writes_back = _addressing(code, word)
    address = base if writes_back and not word & 1 << 10 else offset
    value = code.load(address, size, signed=bool(word & 1 << 24)) if word & 1 << 20 else None
    if value is None:
        code.store(address, size, code.get(number))
    if writes_back:
        code.set(base_number, offset)
    if value is not None:
        code.set(number, value)


def _addressing(code: Follower, word: int) -> tuple[Node, Node, bool]:
    """Return base, base with offset, and whether that is written back."""
    graph, base_number = code.graph, word >> 16 & 0xF
    if base_number == PC:
        base = code.constant(code.pc + 4 & ~3)
        offset = code.constant(word & 0xFFF)
        return base, (graph.add if word & 1 << 23 else graph.sub)(base, offset), False
    base = code.get(base_number)
    if word & 1 << 23:
        return base, graph.add(base, code.constant(word & 0xFFF)), False
    if word & 1 << 11:
        if word >> 8 & 7 == 6:
            raise NotUnderstood("an unprivileged access")
        offset = code.constant(word & 0xFF)
        moved = (graph.add if word & 1 << 9 else graph.sub)(base, offset)
        return base, moved, bool(word & 1 << 8)
    if word & 0xFC0:
        raise NotUnderstood(f"0x{word:08X}")
    return base, graph.add(base, graph.lsl(code.get(word & 0xF), word >> 4 & 3)), False


def _access_dual(code: Follower, word: int) -> None:
    """LDRD and STRD."""
    graph, base_number = code.graph, word >> 16 & 0xF
    indexed, writes_back = bool(word & 1 << 24), bool(word & 1 << 21)
    if not indexed and not writes_back:
        raise NotUnderstood("an exclusive access or a table branch")
    base = code.constant(code.pc + 4 & ~3) if base_number == PC else code.get(base_number)
    moved = (graph.add if word & 1 << 23 else graph.sub)(base, code.constant(4 * (word & 0xFF)))
    address = moved if indexed else base
    addresses = address, graph.add(address, code.constant(4))
    numbers = word >> 12 & 0xF, word >> 8 & 0xF
    if word & 1 << 20:
        values = [code.load(address, 4) for address in addresses]
        for number, value in zip(numbers, values, strict=True):
            code.set(number, value)
    else:
        for address, number in zip(addresses, numbers, strict=True):
            code.store(address, 4, code.get(number))
    if writes_back:
        code.set(base_number, moved)


def _access_multiple(code: Follower, word: int) -> None:
    """LDMIA and STMDB, which PUSH and POP are forms of."""
    graph, base_number, loads = code.graph, word >> 16 & 0xF, bool(word & 1 << 20)
    numbers = [number for number in range(16) if word >> number & 1]
    if base_number in numbers or loads is not bool(word & 1 << 23):
        raise NotUnderstood(f"0x{word:08X}")
    base, size = code.get(base_number), code.constant(4 * len(numbers))
    moved = graph.add(base, size) if loads else graph.sub(base, size)
    bottom = base if loads else moved
    if word & 1 << 21:
        code.set(base_number, moved)
    for index, number in enumerate(numbers):
        address = graph.add(bottom, code.constant(4 * index))
        if loads:
            code.set(number, code.load(address, 4))
        else:
            code.store(address, 4, code.get(number))


# --- branches


def _branch_conditional(code: Follower, word: int) -> None:
    condition = word >> 22 & 0xF
    if condition >= 14:
        if word not in _NOTHING:
            raise NotUnderstood(f"0x{word:08X}")
        return
    offset = (word >> 26 & 1) << 20 | (word >> 11 & 1) << 19 | (word >> 13 & 1) << 18
    code.branch_under(condition, code.pc + 4 + _signed(offset | (word >> 16 & 0x3F) << 12 | (word & 0x7FF) << 1, 21))


def _branch(code: Follower, word: int) -> None:
    sign = word >> 26 & 1
    offset = sign << 24 | (word >> 13 & 1 ^ sign ^ 1) << 23 | (word >> 11 & 1 ^ sign ^ 1) << 22
    target = code.pc + 4 + _signed(offset | (word >> 16 & 0x3FF) << 12 | (word & 0x7FF) << 1, 25)
    if word & 1 << 14:
        code.call(target)
    else:
        code.branch(target)


_INSTRUCTIONS: tuple[tuple[int, int, Callable[[Follower, int], None]], ...] = (
    (0xFA00_8000, 0xF000_0000, _modified_immediate),
    (0xFE00_0000, 0xEA00_0000, _shifted_register),
    (0xFBF0_8000, 0xF200_0000, _plain_sum),
    (0xFBF0_8000, 0xF2A0_0000, _plain_sum),
    (0xFB70_8000, 0xF240_0000, _move_half),
    (0xFFF0_8020, 0xF340_0000, _bit_field),
    (0xFFF0_8020, 0xF360_0000, _bit_field),
    (0xFFF0_8020, 0xF3C0_0000, _bit_field),
    (0xFF80_F0F0, 0xFA00_F000, _shift_by_register),
    (0xFFA0_F0C0, 0xFA00_F080, _extend),
    (0xFFF0_00E0, 0xFB00_0000, _multiply),
    (0xFFD0_00F0, 0xFB80_0000, _multiply_long),
    (0xFFD0_F0F0, 0xFB90_F0F0, _divide),
    (0xFE00_0000, 0xF800_0000, _access),
    (0xFE40_0000, 0xE840_0000, _access_dual),
    (0xFE40_0000, 0xE800_0000, _access_multiple),
    (0xF800_D000, 0xF000_8000, _branch_conditional),
    (0xF800_9000, 0xF000_9000, _branch),
)
