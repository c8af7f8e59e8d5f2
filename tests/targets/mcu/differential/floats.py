"""Atoms of floating point, single and double precision (FPv5; DDI0403 sections A6.4 to A6.7, chapter A7.7).

Registers are S0 to S31 and D0 to D15, which share them; values are anything, often at an edge. FPSCR is written now and
then, so that rounding modes, flush-to-zero, default NaN and the alternative half precision all occur.
"""

from __future__ import annotations

import random
import struct

from tests.targets.mcu.differential.sequence import PC, SP, Sequence

_SINGLE, _DOUBLE = 0, 1
FPSCR_WRITABLE = 0xF7C0_009F


def _first(code: int, vd: int, vn: int, *, d_double: int, n_double: int) -> int:
    """Return the first half with Vn and the bit of Vd that stands in it."""
    return code | (0 if d_double else vd & 1) << 6 | (vn if n_double else vn >> 1)


def _second(code: int, vd: int, vn: int, vm: int, *, double: tuple[int, int, int]) -> int:
    """Return the second half with Vd, Vm and the bits of Vn and Vm that stand in it."""
    d, n, m = double
    half = code | (vd if d else vd >> 1) << 12 | (vm if m else vm >> 1)
    return half | (0 if n else vn & 1) << 7 | (0 if m else vm & 1) << 5


def _register(s: Sequence, size: int) -> int:
    return s.bits(4 if size else 5)


def _three(s: Sequence, first: int, second: int) -> bool:
    """An instruction on three registers of one size."""
    size = s.bits(1)
    vd, vn, vm = (_register(s, size) for _ in range(3))
    return s.emit(
        _first(first, vd, vn, d_double=size, n_double=size),
        _second(second | 0xA00 | size << 8, vd, vn, vm, double=(size,) * 3),
    )


def arithmetic(s: Sequence) -> bool:
    """VMLA, VMLS, VNMLS, VNMLA, VMUL, VNMUL, VADD, VSUB, VDIV, VFMA, VFMS, VFNMS, VFNMA."""
    first = s.one_of(0xEE00, 0xEE10, 0xEE20, 0xEE30, 0xEE30, 0xEE80, 0xEE90, 0xEEA0)
    return _three(s, first, 0 if first == 0xEE80 else s.bits(1) << 6)


def minimum_maximum(s: Sequence) -> bool:
    return not s.in_it and _three(s, 0xFE80, s.bits(1) << 6)


def select(s: Sequence) -> bool:
    return not s.in_it and _three(s, 0xFE00 | s.bits(2) << 4, 0)


def _two(s: Sequence, first: int, second: int, size: int, d_double: int, m_double: int) -> bool:
    vd, vm = _register(s, d_double), _register(s, m_double)
    return s.emit(
        _first(first, vd, 0, d_double=d_double, n_double=1),
        _second(second | 0xA40 | size << 8, vd, 0, vm, double=(d_double, 1, m_double)),
    )


def move_and_root(s: Sequence) -> bool:
    """VMOV, VABS, VNEG, VSQRT."""
    size = s.bits(1)
    return _two(s, s.one_of(0xEEB0, 0xEEB1), s.bits(1) << 7, size, size, size)


def compare(s: Sequence) -> bool:
    """VCMP and VCMPE, with a register or zero; often the flags go to APSR."""
    size = s.bits(1)
    if s.bits(1):
        _two(s, 0xEEB4, s.bits(1) << 7, size, size, size)
    else:
        vd = _register(s, size)
        s.emit(
            _first(0xEEB5, vd, 0, d_double=size, n_double=1),
            _second(0xA40 | size << 8 | s.bits(1) << 7, vd, 0, 0, double=(size, 1, 1)),
        )
    return s.in_it or s.chance(0.5) or s.emit(0xEEF1, 0xFA10)


def round_to_integral(s: Sequence) -> bool:
    """VRINTR, VRINTZ, VRINTX."""
    size, (first, top) = s.bits(1), s.one_of((0xEEB6, 0), (0xEEB6, 0x80), (0xEEB7, 0))
    return _two(s, first, top, size, size, size)


def round_directed(s: Sequence) -> bool:
    """VRINTA, VRINTN, VRINTP, VRINTM."""
    size = s.bits(1)
    return not s.in_it and _two(s, 0xFEB8 | s.bits(2), 0, size, size, size)


def convert_directed(s: Sequence) -> bool:
    """VCVTA, VCVTN, VCVTP, VCVTM."""
    size = s.bits(1)
    return not s.in_it and _two(s, 0xFEBC | s.bits(2), s.bits(1) << 7, size, 0, size)


def convert_size(s: Sequence) -> bool:
    """VCVT between single and double."""
    size = s.bits(1)
    return _two(s, 0xEEB7, 0x80, size, 1 - size, size)


def convert_half(s: Sequence) -> bool:
    """VCVTB and VCVTT, between half and single or double."""
    size, narrows = s.bits(1), s.bits(1)
    return _two(s, 0xEEB2 | narrows, s.bits(1) << 7, size, 0 if narrows else size, size if narrows else 0)


def convert_from_integer(s: Sequence) -> bool:
    size = s.bits(1)
    return _two(s, 0xEEB8, s.bits(1) << 7, size, size, 0)


def convert_to_integer(s: Sequence) -> bool:
    """VCVT, which rounds to zero, and VCVTR."""
    size = s.bits(1)
    return _two(s, 0xEEBC | s.bits(1), s.bits(1) << 7, size, 0, size)


def convert_fixed(s: Sequence) -> bool:
    """VCVT between floating and fixed point, in place."""
    size, wide = s.bits(1), s.bits(1)
    immediate = s.between(0, 31) if wide else s.between(0, 16)  # the width less the bits of the fraction
    first = s.one_of(0xEEBA, 0xEEBB, 0xEEBE, 0xEEBF)
    vd = _register(s, size)
    second = 0xA40 | size << 8 | wide << 7 | (immediate & 1) << 5 | immediate >> 1
    return s.emit(_first(first, vd, 0, d_double=size, n_double=1), second | (vd if size else vd >> 1) << 12)


def move_immediate(s: Sequence) -> bool:
    size = s.bits(1)
    vd = _register(s, size)
    first = _first(0xEEB0 | s.bits(4), vd, 0, d_double=size, n_double=1)
    return s.emit(first, 0xA00 | size << 8 | (vd if size else vd >> 1) << 12 | s.bits(4))


def move_core(s: Sequence) -> bool:
    """VMOV between a core register and a single one, or half of a double one."""
    to_core, half_of_double = s.bits(1), s.bits(1)
    core = s.target() if to_core else s.source()
    if half_of_double:
        return s.emit(0xEE00 | s.bits(1) << 5 | to_core << 4 | s.bits(4), core << 12 | 0xB10)
    vn = s.bits(5)
    return s.emit(0xEE00 | to_core << 4 | vn >> 1, core << 12 | 0xA10 | (vn & 1) << 7)


def move_two_cores(s: Sequence) -> bool:
    """VMOV between two core registers and two single ones or a double one."""
    to_core, size = s.bits(1), s.bits(1)
    if to_core:
        low = s.target()
        high = s.target(without=(low,))
    else:
        low, high = s.source(), s.source()
    vm = s.bits(4) if size else s.between(0, 30)
    place = vm if size else (vm & 1) << 5 | vm >> 1
    return s.emit(0xEC40 | to_core << 4 | high, low << 12 | 0xA10 | size << 8 | place)


def read_status(s: Sequence) -> bool:
    return s.emit(0xEEF1, s.one_of(s.target(), PC) << 12 | 0xA10) if s.chance(0.7) else s.emit(0xEEF1, 0xFA10)


def write_status(s: Sequence) -> bool:
    """VMSR of what a register holds; bits that there are none of are not written."""
    return s.emit(0xEEE1, s.source() << 12 | 0xA10)


def load_store(s: Sequence) -> bool:
    """VLDR and VSTR, with offsets of words up to 1020 either way."""
    size, load = s.bits(1), s.bits(1)
    if (where := s.place(4 << size, range(-1020, 1021, 4), aligned=4)) is None:
        return False
    base, offset = where
    vd = _register(s, size)
    up = s.bits(1) if offset == 0 else offset > 0
    first = _first(0xED00 | up << 7 | load << 4, vd, 0, d_double=size, n_double=1)
    return s.emit(first | base, 0xA00 | size << 8 | (vd if size else vd >> 1) << 12 | abs(offset) // 4)


def load_literal(s: Sequence) -> bool:
    size = s.bits(1)
    vd = _register(s, size)
    first = _first(0xED1F | s.bits(1) << 7, vd, 0, d_double=size, n_double=1)
    return s.emit(first, 0xA00 | size << 8 | (vd if size else vd >> 1) << 12 | s.bits(8))


def load_store_list(s: Sequence) -> bool:
    """VLDM and VSTM, up and down, with and without write-back; VPUSH and VPOP among them."""
    size, load = s.bits(1), s.bits(1)
    down, writes = s.one_of((0, 0), (0, 1), (1, 1))
    count = s.between(1, 5)
    words = count << size
    start = -4 * words if down else 0
    if (where := s.place(4 * words, range(start, start + 1), aligned=4, moves=bool(writes))) is None:
        return False
    base = where[0]
    span = s.known.pointers[base].moved(-4 * words if down else 4 * words)
    if writes and base == SP and not span.on_stack:
        return False
    if writes:
        s.point(base, span)
    vd = s.between(0, (16 if size else 32) - count)
    first = 0xEC00 | (0x100 if down else 0x80) | writes << 5 | load << 4 | base
    first = _first(first, vd, 0, d_double=size, n_double=1)
    return s.emit(first, 0xA00 | size << 8 | (vd if size else vd >> 1) << 12 | words)


COMPUTING = (
    (14, arithmetic),
    (3, minimum_maximum),
    (3, select),
    (4, move_and_root),
    (6, compare),
    (3, round_to_integral),
    (4, round_directed),
    (5, convert_directed),
    (3, convert_size),
    (3, convert_half),
    (3, convert_from_integer),
    (4, convert_to_integer),
    (5, convert_fixed),
    (3, move_immediate),
    (6, move_core),
    (3, move_two_cores),
    (2, read_status),
    (3, write_status),
)
ATOMS = (*COMPUTING, (5, load_store), (1, load_literal), (5, load_store_list))

_SINGLES = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    1.5,
    2.5,
    -2.5,
    3.0,
    0.1,
    65504.0,
    65520.0,
    2.0**31,
    -(2.0**31),
    2.0**32,
    2.0**-149,
]
_PATTERNS = [0x7F80_0000, 0xFF80_0000, 0x7FC0_0000, 0xFFC0_1234, 0x7F80_0001, 0xFFBF_FFFF, 0x7FF0_0000, 0xFFF8_0000]
_PATTERNS += [0x7FF0_0001, 0x0080_0000, 0x007F_FFFF, 0x8000_0001, 0x7F7F_FFFF, 0x0010_0000, 0x800F_FFFF, 0x7FEF_FFFF]


def interesting_float(rng: random.Random) -> int:
    """Return a word that as a single, or as the upper half of a double, is often at an edge."""
    kind = int(rng.random() * 8)
    if kind == 0:
        return rng.getrandbits(32)
    if kind == 1:
        return _PATTERNS[int(rng.random() * len(_PATTERNS))]
    if kind == 2:
        return struct.unpack("<I", struct.pack("<f", _SINGLES[int(rng.random() * len(_SINGLES))]))[0]
    if kind == 3:  # a double's upper half
        return struct.unpack("<2I", struct.pack("<d", _SINGLES[int(rng.random() * len(_SINGLES))]))[1]
    if kind == 4:
        return rng.getrandbits(8)
    if kind == 5:
        return struct.unpack("<I", struct.pack("<f", rng.uniform(-300, 300)))[0]
    if kind == 6:
        return 0
    return (rng.getrandbits(1) << 31) | (rng.randint(100, 160) << 23) | rng.getrandbits(23)


def interesting_status(rng: random.Random) -> int:
    """Return an FPSCR, half of the time that of C: to nearest, nothing flushed."""
    if rng.random() < 0.5:
        return 0
    return rng.getrandbits(32) & FPSCR_WRITABLE
