"""Atoms of the DSP extension: parallel arithmetic, saturation, products of halves (DDI0403 A5.3.12 to A5.3.17)."""

from __future__ import annotations

from tests.targets.mcu.differential.sequence import PC, Sequence


def parallel(s: Sequence) -> bool:
    """ADD8, ADD16, ASX, SUB8, SUB16, SAX: signed, saturating, halving; the same unsigned."""
    operation, kind = s.one_of(0, 1, 2, 4, 5, 6), s.one_of(0, 1, 2, 4, 5, 6)
    return s.emit(0xFA80 | operation << 4 | s.source(), 0xF000 | s.target() << 8 | kind << 4 | s.source())


def saturating_sum(s: Sequence) -> bool:
    """QADD, QDADD, QSUB, QDSUB."""
    return s.emit(0xFA80 | s.source(), 0xF080 | s.target() << 8 | s.bits(2) << 4 | s.source())


def select_bytes(s: Sequence) -> bool:
    return s.emit(0xFAA0 | s.source(), 0xF080 | s.target() << 8 | s.source())


def pack_halves(s: Sequence) -> bool:
    """PKHBT, PKHTB."""
    second = s.bits(3) << 12 | s.target() << 8 | s.bits(2) << 6 | s.bits(1) << 5 | s.source()
    return s.emit(0xEAC0 | s.source(), second)


def extend_and_add(s: Sequence) -> bool:
    """SXTAB, SXTAB16, SXTAH, the same unsigned; SXTB16, UXTB16."""
    operation = s.between(0, 5)
    other = PC if operation in (2, 3) and s.chance(0.3) else s.source()
    return s.emit(0xFA00 | operation << 4 | other, 0xF080 | s.target() << 8 | s.bits(2) << 4 | s.source())


def saturate_halves(s: Sequence) -> bool:
    """SSAT16, USAT16."""
    return s.emit(s.one_of(0xF320, 0xF3A0) | s.source(), s.target() << 8 | s.bits(4))


def product(s: Sequence) -> bool:
    """SMLAxy, SMLAD, SMLAWy, SMLSD, SMMLA, SMMLS, USADA8 and those without an accumulator."""
    operation = s.between(1, 7)
    accumulator = s.source() if operation == 6 or s.chance(0.6) else PC
    variant = s.bits(2) if operation == 1 else 0 if operation == 7 else s.bits(1)
    return s.emit(0xFB00 | operation << 4 | s.source(), accumulator << 12 | s.target() << 8 | variant << 4 | s.source())


def product_long(s: Sequence) -> bool:
    """SMLALxy, SMLALD, SMLSLD, UMAAL."""
    first, second = s.source(), s.source()
    low = s.target()
    high = s.target(without=(low,))
    code, variant = s.one_of((0xFBC0, 8 | s.bits(2)), (0xFBC0, 12 | s.bits(1)), (0xFBD0, 12 | s.bits(1)), (0xFBE0, 6))
    return s.emit(code | first, low << 12 | high << 8 | variant << 4 | second)


ATOMS = (
    (5, parallel),
    (2, saturating_sum),
    (2, select_bytes),
    (2, pack_halves),
    (2, extend_and_add),
    (2, saturate_halves),
    (5, product),
    (3, product_long),
)
