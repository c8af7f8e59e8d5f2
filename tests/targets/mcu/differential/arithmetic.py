"""Atoms that compute: 16-bit and 32-bit data processing, multiplication, division, saturation, bit fields.

Each appends one instruction. In IT blocks the 16-bit forms do not set the flags, with the same encoding.
"""

from __future__ import annotations

from tests.targets.mcu.differential.sequence import INDEX_MAX, LR, PC, SP, Sequence

_TST, _CMP, _CMN = 8, 10, 11
_AND, _BIC, _ORR, _ORN, _EOR, _ADD, _ADC, _SBC, _SUB, _RSB = 0, 1, 2, 3, 4, 8, 10, 11, 13, 14
_OPERATIONS = (_AND, _BIC, _ORR, _ORN, _EOR, _ADD, _ADC, _SBC, _SUB, _RSB)


# --- 16 bits


def shift_immediate(s: Sequence) -> bool:
    operation, amount = s.one_of(0, 1, 2), s.bits(5)
    if s.in_it and operation == amount == 0:
        amount = 1  # as MOVS it would be UNPREDICTABLE
    return s.emit(operation << 11 | amount << 6 | s.source(low=True) << 3 | s.target(low=True))


def add_subtract(s: Sequence) -> bool:
    return s.emit(0x1800 | s.bits(2) << 9 | s.bits(3) << 6 | s.source(low=True) << 3 | s.target(low=True))


def immediate_8(s: Sequence) -> bool:
    operation, value = s.bits(2), s.one_of(s.bits(8), s.bits(5), 0, 32, 33)
    register = s.source(low=True) if operation == 1 else s.target(low=True)
    return s.emit(0x2000 | operation << 11 | register << 8 | value)


def two_low_registers(s: Sequence) -> bool:
    operation, other = s.bits(4), s.source(low=True)
    changed = s.source(low=True) if operation in (_TST, _CMP, _CMN) else s.target(low=True)
    return s.emit(0x4000 | operation << 6 | other << 3 | changed)


def add_high(s: Sequence) -> bool:
    other = s.one_of(s.source(sp=True), PC)
    return s.emit(0x4400 | other << 3 | _split(s.target()))


def compare_high(s: Sequence) -> bool:
    first, second = s.source(sp=True), s.source(sp=True)
    if first < 8 and second < 8:
        first = s.one_of(8, 9, 10, 11, 12, LR)
    return s.emit(0x4500 | second << 3 | _split(first))


def move_high(s: Sequence) -> bool:
    other = s.one_of(s.source(sp=True), s.source(), PC)
    return s.emit(0x4600 | other << 3 | _split(s.target()))


def extend_narrow(s: Sequence) -> bool:
    return s.emit(0xB200 | s.bits(2) << 6 | s.source(low=True) << 3 | s.target(low=True))


def reverse_narrow(s: Sequence) -> bool:
    return s.emit(0xBA00 | s.one_of(0, 1, 3) << 6 | s.source(low=True) << 3 | s.target(low=True))


def address_narrow(s: Sequence) -> bool:
    """ADR, and ADD to SP."""
    return s.emit(s.one_of(0xA000, 0xA800) | s.target(low=True) << 8 | s.bits(8))


# --- 32 bits: data processing


def shifted_register(s: Sequence) -> bool:
    operation = s.one_of(*_OPERATIONS)
    shape = s.bits(3)
    second = _shift(s) | s.source()
    if shape == 0 and operation in (_AND, _EOR, _ADD, _SUB):  # TST, TEQ, CMN, CMP
        first = s.source(sp=operation in (_ADD, _SUB))
        return s.emit(0xEA10 | operation << 5 | first, second | PC << 8)
    if shape == 1 and operation in (_ORR, _ORN):  # MOV with a shift, MVN
        return s.emit(0xEA0F | operation << 5 | s.bits(1) << 4, second | s.target() << 8)
    first = s.source(sp=operation in (_ADD, _SUB))
    return s.emit(0xEA00 | operation << 5 | s.bits(1) << 4 | first, second | s.target() << 8)


def shift_by_immediate_wide(s: Sequence) -> bool:
    """MOV with a shift, RRX among them."""
    second = s.one_of(0x30, _shift(s)) | s.source()
    return s.emit(0xEA4F | s.bits(1) << 4, second | s.target() << 8)


def modified_immediate(s: Sequence) -> bool:
    operation, shape = s.one_of(*_OPERATIONS), s.bits(3)
    code = s.one_of(s.bits(12), s.bits(8), 0x400 | s.bits(10), 0x800 | s.bits(11))
    if 0x100 <= code < 0x400 and not code & 0xFF:
        code |= 0x80  # a pattern of nothing is UNPREDICTABLE
    first = 0xF000 | (code >> 11) << 10 | operation << 5
    second = (code >> 8 & 7) << 12 | code & 0xFF
    if shape == 0 and operation in (_AND, _EOR, _ADD, _SUB):
        return s.emit(first | 0x10 | s.source(sp=operation in (_ADD, _SUB)), second | PC << 8)
    if shape == 1 and operation in (_ORR, _ORN):
        return s.emit(first | s.bits(1) << 4 | PC, second | s.target() << 8)
    to_sp = operation in (_ADD, _SUB)
    other = SP if to_sp and shape == 2 else s.source(sp=to_sp)
    return s.emit(first | s.bits(1) << 4 | other, second | s.target() << 8)


def plain_immediate(s: Sequence) -> bool:
    """ADDW, SUBW (to PC: ADR), MOVW, MOVT."""
    operation = s.one_of(0xF200, 0xF2A0, 0xF240, 0xF2C0)
    other = s.one_of(s.source(sp=True), s.source(), PC) if operation in (0xF200, 0xF2A0) else s.bits(4)
    return s.emit(operation | s.bits(1) << 10 | other, s.bits(3) << 12 | s.target() << 8 | s.bits(8))


def move_stack_pointer(s: Sequence) -> bool:
    """ADD and SUB of constants to SP, MOV and MSR from a pointer."""
    if not s.may_move(SP):
        return False
    if s.chance(0.3):
        return _load_stack_pointer(s)
    words = s.between(0, 12)
    down = s.bits(1)
    span = s.known.pointers[SP].moved(-4 * words if down else 4 * words)
    if not span.on_stack:
        return False
    s.point(SP, span)
    narrow = (0xB000 | down << 7 | words,)
    modified = (0xF10D | down << 7 | down << 5, 0x0D00 | 4 * words)
    plain = (0xF20D | down << 7 | down << 5, 0x0D00 | 4 * words)
    return s.emit(*s.one_of(narrow, modified, plain))


def _load_stack_pointer(s: Sequence) -> bool:
    fit = [r for r, span in s.known.pointers.items() if r != SP and span.on_stack]
    if not fit:
        return False
    register = s.one_of(*fit)
    s.point(SP, s.known.pointers[register])
    if s.chance(0.5):
        return s.emit(0x4685 | register << 3)
    return s.emit(0xF380 | register, 0x8808)  # MSR MSP


def shift_by_register(s: Sequence) -> bool:
    return s.emit(0xFA00 | s.bits(3) << 4 | s.source(), 0xF000 | s.target() << 8 | s.source())


def extend_wide(s: Sequence) -> bool:
    operation = s.one_of(0, 1, 4, 5)
    return s.emit(0xFA0F | operation << 4, 0xF080 | s.target() << 8 | s.bits(2) << 4 | s.source())


def reverse_wide(s: Sequence) -> bool:
    other = s.source()
    return s.emit(0xFA90 | other, 0xF080 | s.target() << 8 | s.bits(2) << 4 | other)


def count_leading_zeros(s: Sequence) -> bool:
    other = s.source()
    return s.emit(0xFAB0 | other, 0xF080 | s.target() << 8 | other)


# --- 32 bits: multiplication, division, saturation, bit fields


def multiply(s: Sequence) -> bool:
    """MUL, MLA, MLS."""
    accumulator, subtract = s.one_of((PC, 0), (s.source(), 0), (s.source(), 1))
    return s.emit(0xFB00 | s.source(), accumulator << 12 | s.target() << 8 | subtract << 4 | s.source())


def multiply_long(s: Sequence) -> bool:
    """SMULL, UMULL, SMLAL, UMLAL."""
    first, second = s.source(), s.source()
    low = s.target()
    high = s.target(without=(low,))
    return s.emit(0xFB80 | s.bits(2) << 5 | first, low << 12 | high << 8 | second)


def divide(s: Sequence) -> bool:
    return s.emit(s.one_of(0xFB90, 0xFBB0) | s.source(), 0xF0F0 | s.target() << 8 | s.source())


def saturate(s: Sequence) -> bool:
    """SSAT and USAT, with either shift; ASR by 0 would be another instruction."""
    arithmetic, amount = s.bits(1), s.bits(5)
    if arithmetic and not amount:
        amount = 1
    first = s.one_of(0xF300, 0xF380) | arithmetic << 5 | s.source()
    return s.emit(first, (amount >> 2) << 12 | s.target() << 8 | (amount & 3) << 6 | s.bits(5))


def extract_field(s: Sequence) -> bool:
    """SBFX and UBFX."""
    low = s.bits(5)
    width = s.between(0, 31 - low)
    first = s.one_of(0xF340, 0xF3C0) | s.source()
    return s.emit(first, (low >> 2) << 12 | s.target() << 8 | (low & 3) << 6 | width)


def insert_field(s: Sequence) -> bool:
    """BFI and BFC."""
    low = s.bits(5)
    high = s.between(low, 31)
    first = 0xF360 | s.one_of(s.source(), s.source(), PC)
    return s.emit(first, (low >> 2) << 12 | s.target() << 8 | (low & 3) << 6 | high)


# --- a register for offsets and tables


def make_index(s: Sequence) -> bool:
    """Put 0 to INDEX_MAX into a register, by UBFX, AND or MOVS."""
    if s.known.frozen:
        return False
    kind, other = s.between(0, 2), s.source()
    register = s.target(low=kind == 2 or s.chance(0.5))
    s.know_index(register)
    if kind == 0:
        low = s.between(0, 29)
        return s.emit(0xF3C0 | other, (low >> 2) << 12 | register << 8 | (low & 3) << 6 | 2)
    if kind == 1:
        return s.emit(0xF000 | other, register << 8 | INDEX_MAX)
    return s.emit(0x2000 | register << 8 | s.bits(3))


def _split(register: int) -> int:
    """Return a register of four bits where the fourth stands apart."""
    return (register >> 3) << 7 | register & 7


def _shift(s: Sequence) -> int:
    """Return type and amount of a shift by a constant; ROR by 0 is RRX."""
    amount = s.one_of(0, s.bits(5))
    return (amount >> 2) << 12 | (amount & 3) << 6 | s.bits(2) << 4


ATOMS = (
    (3, shift_immediate),
    (3, add_subtract),
    (5, immediate_8),
    (6, two_low_registers),
    (1, add_high),
    (1, compare_high),
    (1, move_high),
    (1, extend_narrow),
    (1, reverse_narrow),
    (1, address_narrow),
    (6, shifted_register),
    (2, shift_by_immediate_wide),
    (5, modified_immediate),
    (2, plain_immediate),
    (1, move_stack_pointer),
    (2, shift_by_register),
    (1, extend_wide),
    (1, reverse_wide),
    (1, count_leading_zeros),
    (2, multiply),
    (2, multiply_long),
    (2, divide),
    (3, saturate),
    (2, extract_field),
    (2, insert_field),
    (2, make_index),
)
