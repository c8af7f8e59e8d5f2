"""Atoms that load and store: every size and addressing mode, pairs, lists, the stack, exclusive pairs."""

from __future__ import annotations

from tests.targets.mcu.differential.arithmetic import make_index
from tests.targets.mcu.differential.sequence import INDEX_MAX, PC, SP, Sequence

# second byte of the 32-bit encodings (without bit 7, the 12-bit offset): size in bytes, is it a load
_WIDE = {0xF800: (1, False), 0xF820: (2, False), 0xF840: (4, False)}
_WIDE |= {0xF810: (1, True), 0xF830: (2, True), 0xF850: (4, True), 0xF910: (1, True), 0xF930: (2, True)}
_LITERALS = (0xF81F, 0xF83F, 0xF85F, 0xF91F, 0xF93F)

# 16-bit encodings with an index register, in the order of their operation field
_NARROW = ((4, False), (2, False), (1, False), (1, True), (4, True), (2, True), (1, True), (2, True))


# --- single accesses, 16 bits


def narrow_offset(s: Sequence) -> bool:
    """A word, byte or half-word at a low register plus five bits."""
    opcode, size = s.one_of((0x6000, 4), (0x7000, 1), (0x8000, 2))
    if (where := s.place(size, range(0, 32 * size, size), low=True)) is None:
        return False
    load, (base, offset) = s.bits(1), where
    register = s.target(low=True) if load else s.source(low=True)
    return s.emit(opcode | load << 11 | offset // size << 6 | base << 3 | register)


def narrow_index(s: Sequence) -> bool:
    operation, index = s.bits(3), _index(s, low=True)
    size, load = _NARROW[operation]
    if index is None or (where := s.place(size + INDEX_MAX, range(1), low=True)) is None:
        return False
    first, second = s.one_of((where[0], index), (index, where[0]))
    register = s.target(low=True) if load else s.source(low=True)
    return s.emit(0x5000 | operation << 9 | second << 6 | first << 3 | register)


def narrow_stack(s: Sequence) -> bool:
    if (where := s.offset(SP, 4, range(0, 1024, 4))) is None:
        return False
    load = s.bits(1)
    register = s.target(low=True) if load else s.source(low=True)
    return s.emit(0x9000 | load << 11 | register << 8 | where // 4)


def narrow_literal(s: Sequence) -> bool:
    return s.emit(0x4800 | s.target(low=True) << 8 | s.bits(8))


# --- single accesses, 32 bits


def wide_offset(s: Sequence) -> bool:
    """Twelve bits up, or eight bits down."""
    opcode, size, load = _wide(s)
    down = s.chance(0.4)
    if (where := s.place(size, range(-255, 1) if down else range(4096))) is None:
        return False
    base, offset = where
    register = _moved(s, size, load=load)
    if down:
        return s.emit(opcode | base, register << 12 | 0xC00 | -offset)
    return s.emit(opcode | 0x80 | base, register << 12 | offset)


def wide_write_back(s: Sequence) -> bool:
    """The offset before or after the access, with write-back."""
    opcode, size, load = _wide(s)
    step = s.one_of(1, 4, 4)
    before = s.chance(0.5)
    reach = range(-252, 253, step) if before else range(1)
    if (where := s.place(size, reach, moves=True, sp=step == 4)) is None:
        return False
    base, offset = where
    if not before:
        offset = s.between(-252 // step, 252 // step) * step
    span = s.known.pointers[base].moved(offset)
    if base == SP and not span.on_stack:
        return False
    register = s.target(without=(base,)) if load else s.source()
    if register == base:
        return False
    s.point(base, span)
    up = s.bits(1) if offset == 0 else offset > 0
    return s.emit(opcode | base, register << 12 | 0x900 | before << 10 | up << 9 | abs(offset))


def wide_unprivileged(s: Sequence) -> bool:
    opcode, size, load = _wide(s)
    if (where := s.place(size, range(256))) is None:
        return False
    base, offset = where
    register = s.target() if load else s.source()
    return s.emit(opcode | base, register << 12 | 0xE00 | offset)


def wide_index(s: Sequence) -> bool:
    opcode, size, load = _wide(s)
    shift, index = s.bits(2), _index(s)
    if index is None or (where := s.place(size + (INDEX_MAX << shift), range(1))) is None:
        return False
    base = where[0]
    if shift == 0 and base != SP and s.chance(0.3):
        base, index = index, base
    return s.emit(opcode | base, _moved(s, size, load=load) << 12 | shift << 4 | index)


def wide_literal(s: Sequence) -> bool:
    return s.emit(s.one_of(*_LITERALS) | s.bits(1) << 7, s.target() << 12 | s.bits(12))


def preload(s: Sequence) -> bool:
    """PLD and PLI, of any address."""
    data, base = s.one_of(0xF810, 0xF910), s.source(sp=True)
    up, down = (data | 0x80 | base, 0xF000 | s.bits(12)), (data | base, 0xFC00 | s.bits(8))
    literal = data | s.bits(1) << 7 | PC, 0xF000 | s.bits(12)
    index = data | base, 0xF000 | s.bits(2) << 4 | s.source()
    return s.emit(*s.one_of(up, down, literal, index))


# --- pairs and lists


def pair(s: Sequence) -> bool:
    """LDRD and STRD: offset, before, after."""
    before, writes, load = (*s.one_of((1, 0), (1, 1), (0, 1)), s.bits(1))
    reach = range(-1020, 1021, 4) if before else range(1)
    if (where := s.place(8, reach, aligned=4, moves=bool(writes))) is None:
        return False
    base, offset = where
    if not before:
        offset = 4 * s.between(-60, 60)
    span = s.known.pointers[base].moved(offset)
    if writes and base == SP and not span.on_stack:
        return False
    if not (registers := _pair_registers(s, base, load=bool(load), writes=bool(writes))):
        return False
    if writes:
        s.point(base, span)
    up = s.bits(1) if offset == 0 else offset > 0
    first = 0xE840 | before << 8 | up << 7 | writes << 5 | load << 4 | base
    return s.emit(first, registers[0] << 12 | registers[1] << 8 | abs(offset) // 4)


def _pair_registers(s: Sequence, base: int, *, load: bool, writes: bool) -> tuple[int, int] | None:
    if load:
        first = s.target(without=(base,) if writes else ())
        return first, s.target(without=(base, first))
    first, second = s.source(), s.source()
    return None if writes and base in (first, second) else (first, second)


def pair_literal(s: Sequence) -> bool:
    first = s.target()
    second = s.target(without=(first,))
    return s.emit(0xE95F | s.bits(1) << 7, first << 12 | second << 8 | s.bits(8))


def list_wide(s: Sequence) -> bool:
    """LDM and STM, up and down, with and without write-back."""
    count, load, down, writes = s.between(2, 8), s.bits(1), s.bits(1), s.bits(1)
    start = -4 * count if down else 0
    if (where := s.place(4 * count, range(start, start + 1), aligned=4, moves=bool(writes))) is None:
        return False
    base = where[0]
    span = s.known.pointers[base].moved(-4 * count if down else 4 * count)
    if writes and base == SP and not span.on_stack:
        return False
    registers = _some(s, count, (base,) if writes else (), load=bool(load))
    if registers is None:
        return False
    if writes:
        s.point(base, span)
    first = 0xE800 | (0x100 if down else 0x80) | writes << 5 | load << 4 | base
    return s.emit(first, _mask(registers))


def list_narrow(s: Sequence) -> bool:
    """LDM without write-back if the base is loaded; STM with the base in the list only as the lowest."""
    count, load = s.between(1, 5), s.bits(1)
    if (where := s.place(4 * count, range(1), aligned=4, low=True, moves=True)) is None:
        return False
    base = where[0]
    registers = _some(s, count, (base,), load=bool(load), low=True)
    if registers is None:
        return False
    if s.chance(0.2):
        if load and len(s.known.pointers) > 2:
            registers = {*sorted(registers)[1:], base}
            s.forget(base)
            return s.emit(0xC800 | base << 8 | _mask(registers))
        if not load and base < min(registers):
            registers = {*sorted(registers)[1:], base}
    s.point(base, s.known.pointers[base].moved(4 * count))
    return s.emit(0xC000 | load << 11 | base << 8 | _mask(registers))


def push(s: Sequence) -> bool:
    count, with_lr = s.between(1, 6), s.bits(1)
    words = count + with_lr
    if s.offset(SP, 4 * words, range(-4 * words, -4 * words + 1), moves=True) is None:
        return False
    registers = _some(s, count, (), load=False, low=True)
    s.point(SP, s.known.pointers[SP].moved(-4 * words))
    return s.emit(0xB400 | with_lr << 8 | _mask(registers))


def pop(s: Sequence) -> bool:
    count = s.between(1, 4)
    if s.offset(SP, 4 * count, range(1), moves=True) is None:
        return False
    if (registers := _some(s, count, (), load=True, low=True)) is None:
        return False
    s.point(SP, s.known.pointers[SP].moved(4 * count))
    return s.emit(0xBC00 | _mask(registers))


# --- helpers


def single_stack(s: Sequence) -> bool:
    """PUSH and POP of one register, the wide encodings."""
    load = s.bits(1)
    by = 4 if load else -4
    if s.offset(SP, 4, range(1) if load else range(-4, -3), moves=True) is None:
        return False
    register = s.target() if load else s.source()
    s.point(SP, s.known.pointers[SP].moved(by))
    return s.emit(0xF85D if load else 0xF84D, register << 12 | (0xB04 if load else 0xD04))


def _index(s: Sequence, *, low: bool = False) -> int | None:
    """Return the register for offsets, made on the spot if need and possible be; None if it is not there."""
    index = s.known.index
    if (index is None or (low and index > 7)) and not s.in_it:
        make_index(s)
        index = s.known.index
    return None if low and index is not None and index > 7 else index


def _wide(s: Sequence) -> tuple[int, int, bool]:
    opcode = s.one_of(*_WIDE)
    return opcode, *_WIDE[opcode]


def _moved(s: Sequence, size: int, *, load: bool) -> int:
    """Return the register to load or to store; SP may only be stored, as a word."""
    return s.target() if load else s.source(sp=size == 4)


def _some(s: Sequence, count: int, without: tuple[int, ...], *, load: bool, low: bool = False) -> set[int] | None:
    """Return `count` registers for a list; None if there are not so many."""
    registers: set[int] = set()
    for _ in range(8 * count):
        if len(registers) == count:
            return registers
        register = s.target(low=low, without=without) if load else s.source(low=low)
        if register not in without:
            registers.add(register)
    return None


def _mask(registers: set[int]) -> int:
    return sum(1 << register for register in registers)


ATOMS = (
    (4, narrow_offset),
    (3, narrow_index),
    (2, narrow_stack),
    (1, narrow_literal),
    (4, wide_offset),
    (5, wide_write_back),
    (1, wide_unprivileged),
    (5, wide_index),
    (1, wide_literal),
    (1, preload),
    (4, pair),
    (1, pair_literal),
    (4, list_wide),
    (3, list_narrow),
    (3, push),
    (3, pop),
    (1, single_stack),
)
