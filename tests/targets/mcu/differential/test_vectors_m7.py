"""DSP and floating point against the architecture manual: what DDI0403 says by its pseudo-code, worked out by hand.

What stands here comes from no emulator.
"""

from __future__ import annotations

import math
import random
import struct
from fractions import Fraction

import pytest

from targets.mcu.cortexm.kinds import CORTEX_M7
from targets.mcu.engine.api import Reg
from targets.mcu.engine.core_engine import CoreEngine
from targets.mcu.engine.timing import make_timing
from tests.each import each

CODE = 0x0800_0100
MIN, MAX, ONES = 0x8000_0000, 0x7FFF_FFFF, 0xFFFF_FFFF
TO_NEAREST, UP, DOWN, TO_ZERO = (mode << 22 for mode in range(4))
FZ, DN, AHP = 1 << 24, 1 << 25, 1 << 26
IOC, DZC, OFC, UFC, IXC, IDC = 1, 2, 4, 8, 16, 128
QNAN, SNAN, DEFAULT = 0x7FC0_1234, 0xFF80_5678, 0x7FC0_0000
INF, DENORMAL, SMALLEST = 0x7F80_0000, 0x0000_1234, 0x0080_0000


def single(value):
    return struct.unpack("<I", struct.pack("<f", value))[0]


def double(value):
    """Return the halves of a double, the lower one first."""
    return list(struct.unpack("<2I", struct.pack("<d", value)))


class Core:
    """An M7 with some flash; executes an instruction at a time."""

    def __init__(self):
        self.engine = CoreEngine(make_timing("flat", CORTEX_M7), CORTEX_M7)
        self.flash = bytearray(0x400)
        self.engine.map_memory(CODE & ~0xFFF, self.flash, writable=False)

    def execute(self, *halves, singles=(), fpscr=0, xpsr=0, **registers):
        """Execute one wide instruction; return S0 to S31 and FPSCR."""
        engine = self.engine
        self.flash[0x100:0x108] = struct.pack("<4H", *halves, 0xBF00, 0xBF00)
        engine.forget(CODE & ~0xFFF, len(self.flash))
        engine.set(Reg.CONTROL, 4)
        for register in list(Reg)[:13]:
            engine.set(register, registers.get(register.name.lower(), 0))
        engine.set(Reg.XPSR, 1 << 24 | xpsr)
        engine.set(Reg.PC, CODE)
        engine.set_floats([*singles, *[0] * (32 - len(singles)), fpscr])
        engine.run(1 << 40, 1)
        return engine.get_floats()

    @property
    def r0(self):
        return self.engine.get(Reg.R0)

    @property
    def xpsr(self):
        return self.engine.get(Reg.XPSR)


@pytest.fixture(scope="module")
def core():
    return Core()


# --- on s0 and s1, into s2 (f32), and on d0 and d1, into d2 (f64)

VADD, VSUB, VMUL, VDIV = (0xEE30, 0x1A20), (0xEE30, 0x1A60), (0xEE20, 0x1A20), (0xEE80, 0x1A20)
VNMUL, VMINNM, VMAXNM = (0xEE20, 0x1A60), (0xFE80, 0x1A60), (0xFE80, 0x1A20)
SINGLES = [
    (VADD, 0, single(1.5), single(2.25), single(3.75), 0),
    (VADD, TO_NEAREST, single(1.0), single(2.0**-24), single(1.0), IXC),
    (VADD, UP, single(1.0), single(2.0**-24), single(1.0) + 1, IXC),
    (VADD, DOWN, single(-1.0), single(-(2.0**-24)), single(-1.0) + 1, IXC),
    (VADD, TO_ZERO, single(-1.0), single(-(2.0**-24)), single(-1.0), IXC),
    (VADD, 0, INF, INF | MIN, DEFAULT, IOC),
    (VADD, 0, 0, MIN, 0, 0),
    (VADD, DOWN, 0, MIN, MIN, 0),
    (VSUB, 0, single(1.0), single(1.0), 0, 0),
    (VSUB, DOWN, single(1.0), single(1.0), MIN, 0),
    (VMUL, 0, 0, INF, DEFAULT, IOC),
    (VMUL, 0, 0x7F00_0000, single(4.0), INF, OFC | IXC),
    (VMUL, TO_ZERO, 0x7F00_0000, single(4.0), 0x7F7F_FFFF, OFC | IXC),
    (VMUL, 0, SMALLEST, single(0.5), 0x0040_0000, 0),
    (VMUL, FZ, SMALLEST, single(0.5), 0, UFC),
    (VMUL, FZ, SMALLEST, single(-0.5), MIN, UFC),
    (VMUL, 0, 1, single(0.5), 0, UFC | IXC),
    (VNMUL, 0, single(2.0), single(3.0), single(-6.0), 0),
    (VDIV, 0, single(1.0), 0, INF, DZC),
    (VDIV, 0, single(-1.0), 0, INF | MIN, DZC),
    (VDIV, 0, 0, 0, DEFAULT, IOC),
    (VDIV, 0, single(1.0), single(3.0), 0x3EAA_AAAB, IXC),
    (VDIV, TO_ZERO, single(1.0), single(3.0), 0x3EAA_AAAA, IXC),
    # denormal numbers, flushed as operands
    (VADD, 0, DENORMAL, 0, DENORMAL, 0),
    (VADD, FZ, DENORMAL, 0, 0, IDC),
    (VADD, FZ, DENORMAL | MIN, MIN, MIN, IDC),
    # NaN: the first signalling one, made quiet, or the first quiet one, or the default
    (VADD, 0, QNAN, single(1.0), QNAN, 0),
    (VADD, 0, single(1.0), QNAN | MIN, QNAN | MIN, 0),
    (VADD, 0, QNAN, SNAN, SNAN | 0x40_0000, IOC),
    (VADD, 0, QNAN, QNAN | MIN, QNAN, 0),
    (VADD, DN, QNAN, single(1.0), DEFAULT, 0),
    (VADD, DN, SNAN, single(1.0), DEFAULT, IOC),
    # a quiet NaN is no number, the other operand is; a signalling one is an error
    (VMAXNM, 0, QNAN, single(1.0), single(1.0), 0),
    (VMINNM, 0, single(-1.0), QNAN, single(-1.0), 0),
    (VMINNM, 0, QNAN, QNAN | MIN, QNAN, 0),
    (VMINNM, 0, SNAN, single(1.0), SNAN | 0x40_0000, IOC),
    (VMINNM, 0, 0, MIN, MIN, 0),
    (VMAXNM, 0, MIN, 0, 0, 0),
]


@each(("code", "modes", "a", "b", "result", "flags"), SINGLES)
def test_single_precision(core, code, modes, a, b, result, flags):
    floats = core.execute(*code, singles=[a, b], fpscr=modes)
    assert (hex(floats[2]), floats[32]) == (hex(result), modes | flags)


def test_sums_and_products_of_doubles(core):
    """Python's floats are doubles, rounded to nearest."""
    rng = random.Random(7)
    for _ in range(200):
        a, b = (math.ldexp(rng.uniform(-1, 1), rng.randint(-60, 60)) for _ in range(2))
        for (first, second), result in (
            ((0xEE30, 0x2B01), a + b),
            ((0xEE20, 0x2B01), a * b),
            ((0xEE80, 0x2B01), a / b),
        ):
            floats = core.execute(first, second, singles=[*double(a), *double(b)])
            assert floats[4:6] == double(result)
        floats = core.execute(0xEEB1, 0x2BC0, singles=double(abs(a)))  # vsqrt.f64 d2, d0
        assert floats[4:6] == double(math.sqrt(abs(a)))


def nearest_single(exact):
    """Return the single next to a fraction in the normal range, ties to even."""
    if not exact:
        return 0.0
    exponent = math.floor(math.log2(abs(exact)))
    while abs(exact) >= Fraction(2) ** (exponent + 1):
        exponent += 1
    while abs(exact) < Fraction(2) ** exponent:
        exponent -= 1
    step = Fraction(2) ** (exponent - 23)
    return float(round(exact / step) * step)


@each(
    ("code", "formula"),
    [
        ((0xEEA0, 0x1A20), lambda d, n, m: d + n * m),  # vfma.f32 s2, s0, s1
        ((0xEEA0, 0x1A60), lambda d, n, m: d - n * m),  # vfms
        ((0xEE90, 0x1A60), lambda d, n, m: -d - n * m),  # vfnma
        ((0xEE90, 0x1A20), lambda d, n, m: -d + n * m),  # vfnms
    ],
)
def test_fused_products_round_once(core, code, formula):
    rng = random.Random(11)
    for _ in range(100):
        operands = [struct.unpack("<f", struct.pack("<f", rng.uniform(-8, 8)))[0] for _ in range(3)]
        n, m, d = operands
        exact = formula(*(Fraction(value) for value in (d, n, m)))
        floats = core.execute(*code, singles=[single(value) for value in operands])
        assert floats[2] == single(nearest_single(exact))


def test_products_that_are_not_fused_round_twice(core):
    """VMLA, VMLS, VNMLA, VNMLS of 1 + 2**-23 squared and -1."""
    n, d = single(1.0) + 1, single(-1.0)
    squared = struct.unpack("<f", struct.pack("<f", (1 + 2.0**-23) ** 2))[0]
    for code, result in (
        ((0xEE00, 0x1A20), -1 + squared),
        ((0xEE00, 0x1A60), -1 - squared),
        ((0xEE10, 0x1A60), 1 - squared),
        ((0xEE10, 0x1A20), 1 + squared),
    ):
        assert core.execute(*code, singles=[n, n, d])[2] == single(result)


# --- comparison: NZCV of less, equal, greater, unordered

LESS, EQUAL, GREATER, UNORDERED = 0x8000_0000, 0x6000_0000, 0x2000_0000, 0x3000_0000


@each(
    ("code", "a", "b", "flags"),
    [
        ((0xEEB4, 0x0A60), single(1.0), single(2.0), LESS),  # vcmp.f32 s0, s1
        ((0xEEB4, 0x0A60), 0, MIN, EQUAL),
        ((0xEEB4, 0x0A60), INF, single(2.0), GREATER),
        ((0xEEB4, 0x0A60), QNAN, single(2.0), UNORDERED),
        ((0xEEB4, 0x0A60), SNAN, single(2.0), UNORDERED | IOC),
        ((0xEEB4, 0x0AE0), QNAN, single(2.0), UNORDERED | IOC),  # vcmpe
        ((0xEEB5, 0x0A40), single(-1.0), 0, LESS),  # vcmp.f32 s0, #0
    ],
)
def test_comparison(core, code, a, b, flags):
    assert core.execute(*code, singles=[a, b])[32] == flags
    core.execute(0xEEF1, 0xFA10, fpscr=flags)  # vmrs apsr_nzcv, fpscr
    assert core.xpsr & 0xF000_0000 == flags & 0xF000_0000


@each(
    ("condition", "flags", "first"),
    [
        *((0, EQUAL, True), (0, LESS, False), (1, UNORDERED, True), (1, LESS, False)),
        *((2, EQUAL, True), (2, GREATER, True), (2, LESS, False)),
        *((3, GREATER, True), (3, EQUAL, False), (3, UNORDERED, False)),
    ],
)
def test_selection(core, condition, flags, first):
    """VSEL EQ, VS, GE, GT by the flags of the core."""
    floats = core.execute(0xFE00 | condition << 4, 0x1A20, singles=[11, 22], xpsr=flags)
    assert floats[2] == (11 if first else 22)


# --- conversions

S32, U32 = (0xEEBD, 0x1AC0), (0xEEBC, 0x1AC0)  # vcvt.s32.f32 s2, s0; vcvt.u32.f32: to zero
S32R = (0xEEBD, 0x1A40)  # vcvtr.s32.f32
VCVTA, VCVTN, VCVTP, VCVTM = ((first, 0x1AC0) for first in (0xFEBC, 0xFEBD, 0xFEBE, 0xFEBF))


@each(
    ("code", "modes", "value", "result", "flags"),
    [
        (S32, UP, 2.7, 2, IXC),
        (S32, 0, -2.7, -2 & ONES, IXC),
        (S32, 0, 3e9, MAX, IOC),
        (S32, 0, -3e9, MIN, IOC),
        (S32, 0, math.inf, MAX, IOC),
        (U32, 0, 3e9, 3_000_000_000, 0),
        (U32, 0, -1.0, 0, IOC),
        (U32, 0, -0.5, 0, IXC),
        (U32, 0, 5e9, ONES, IOC),
        (S32R, TO_NEAREST, 2.5, 2, IXC),
        (S32R, UP, 2.1, 3, IXC),
        (S32R, DOWN, -2.1, -3 & ONES, IXC),
        (VCVTA, UP, 2.5, 3, IXC),
        (VCVTA, 0, -2.5, -3 & ONES, IXC),
        (VCVTN, UP, 2.5, 2, IXC),
        (VCVTN, 0, 3.5, 4, IXC),
        (VCVTP, 0, 2.1, 3, IXC),
        (VCVTM, 0, -2.1, -3 & ONES, IXC),
    ],
)
def test_to_integer(core, code, modes, value, result, flags):
    floats = core.execute(*code, singles=[single(value)], fpscr=modes)
    assert (floats[2], floats[32]) == (result, modes | flags)


def test_a_nan_is_no_integer(core):
    assert core.execute(*S32, singles=[QNAN])[2::30] == [0, IOC]


@each(
    ("code", "value", "result", "flags"),
    [
        ((0xFEB8, 0x1A40), 2.5, 3.0, 0),  # vrinta.f32 s2, s0: inexact is not signalled
        ((0xFEB9, 0x1A40), 2.5, 2.0, 0),
        ((0xFEBA, 0x1A40), 2.1, 3.0, 0),
        ((0xFEBB, 0x1A40), -2.1, -3.0, 0),
        ((0xEEB6, 0x1AC0), -2.9, -2.0, 0),  # vrintz
        ((0xEEB6, 0x1A40), 2.9, 3.0, 0),  # vrintr
        ((0xEEB7, 0x1A40), 2.9, 3.0, IXC),  # vrintx
        ((0xFEBA, 0x1A40), -0.5, -0.0, 0),
    ],
)
def test_to_integral(core, code, value, result, flags):
    assert core.execute(*code, singles=[single(value)])[2::30] == [single(result), flags]


@each(
    ("halves", "before", "after", "flags"),
    [
        ((0xEEB3, 0x0A60), [0xAAAA_AAAA, single(1.0)], 0xAAAA_3C00, 0),  # vcvtb.f16.f32 s0, s1
        ((0xEEB3, 0x0AE0), [0xAAAA_AAAA, single(-2.0)], 0xC000_AAAA, 0),  # vcvtt
        ((0xEEB3, 0x0A60), [0, single(65520.0)], 0x7C00, OFC | IXC),
        ((0xEEB2, 0x0A60), [0, 0x7E00_3C00], single(1.0), 0),  # vcvtb.f32.f16
        ((0xEEB2, 0x0AE0), [0, 0x7E00_3C00], 0x7FC0_0000, 0),  # vcvtt.f32.f16 of a NaN
        ((0xEEB2, 0x0A60), [0, 0x0001], single(2.0**-24), 0),
    ],
)
def test_half_precision(core, halves, before, after, flags):
    assert core.execute(*halves, singles=before)[0::32] == [after, flags]


def test_alternative_half_precision_has_no_infinity(core):
    assert core.execute(0xEEB2, 0x0A60, singles=[0, 0x7C00], fpscr=AHP)[0] == single(65536.0)
    assert core.execute(0xEEB3, 0x0A60, singles=[0, single(65536.0)], fpscr=AHP)[0] == 0x7C00


@each(
    ("halves", "before", "after", "flags"),
    [
        ((0xEEBA, 0x0AE8), -256 & ONES, single(-256 / 2**15), 0),  # vcvt.f32.s32 s0, s0, #15
        ((0xEEBB, 0x0A44), 0xFFFF_0100, single(1.0), 0),  # vcvt.f32.u16 s0, s0, #8: the lower half alone
        ((0xEEBE, 0x0AE8), single(1.75), 1.75 * 2**15, 0),  # vcvt.s32.f32 s0, s0, #15
        ((0xEEBF, 0x0A44), single(300.0), 0xFFFF, IOC),  # vcvt.u16.f32 s0, s0, #8
        ((0xEEBE, 0x0A44), single(-1.5), -384 & ONES, 0),  # vcvt.s16.f32 s0, s0, #8: the sign fills the upper half
    ],
)
def test_fixed_point(core, halves, before, after, flags):
    assert core.execute(*halves, singles=[before])[0::32] == [after, flags]


def test_between_sizes(core):
    assert core.execute(0xEEB7, 0x1AC0, singles=[single(0.1)])[2:4] == double(
        struct.unpack("<f", struct.pack("<f", 0.1))[0]
    )
    assert core.execute(0xEEB7, 0x1BC0, singles=double(0.1))[2::30] == [single(0.1), IXC]
    assert core.execute(0xEEB7, 0x1AC0, singles=[SNAN])[2:4] == [0, 0xFFF8_0ACF]  # its payload, moved up


# --- DSP: R1, R2, (R3 or GE) and what becomes of R0, GE and Q

GE, Q = 0x000F_0000, 1 << 27


@each(
    ("code", "r1", "r2", "r0", "flags"),
    [
        ((0xFA81, 0xF002), 0x7F80_01FF, 0x0180_0101, 0x8000_0200, 0xB),  # sadd8 r0, r1, r2: GE of sums not below 0
        ((0xFA81, 0xF042), 0x7F80_01FF, 0x0180_0101, 0x8000_0200, 0x5),  # uadd8: GE of carries
        ((0xFA81, 0xF012), 0x7F80_01FF, 0x0180_0101, 0x7F80_0200, 0),  # qadd8
        ((0xFA81, 0xF052), 0x7F80_01FF, 0x0180_0101, 0x80FF_02FF, 0),  # uqadd8
        ((0xFA81, 0xF022), 0x7F80_01FF, 0x0180_0101, 0x4080_0100, 0),  # shadd8
        ((0xFAC1, 0xF042), 0x0506_0708, 0x0606_0000, 0xFF00_0708, 0x7),  # usub8: GE where nothing was borrowed
        ((0xFAA1, 0xF002), 0x0001_0002, 0x0003_0004, 0x0005_FFFF, 0xC),  # sasx
        ((0xFAE1, 0xF002), 0x0001_0002, 0x0003_0004, 0xFFFD_0005, 0x3),  # ssax
        ((0xFA82, 0xF081), MAX, 1, MAX, Q),  # qadd r0, r1, r2
        ((0xFA82, 0xF0A1), MIN, 1, MIN, Q),  # qsub
        ((0xFA82, 0xF091), 1, 0x4000_0000, MAX, Q),  # qdadd: the doubling saturates
        ((0xEAC1, 0x2002), 0x0000_1234, 0x00AB_CD00, 0xABCD_1234, 0),  # pkhbt r0, r1, r2, lsl #8
        ((0xF321, 0x0007), 0x0100_FF00, 0, 0x007F_FF80, Q),  # ssat16 r0, #8, r1
        ((0xF3A1, 0x0008), 0x0100_FF00, 0, 0x00FF_0000, Q),  # usat16 r0, #8, r1
        ((0xFA21, 0xF082), 0x0001_0001, 0x1280_34FF, 0xFF81_0000, 0),  # sxtab16 r0, r1, r2
        ((0xFB11, 0xF002), 0x0000_8000, 0x0000_8000, 0x4000_0000, 0),  # smulbb
        ((0xFB11, 0xF032), 0x0002_0000, 0xFFFF_0000, -2 & ONES, 0),  # smultt
        ((0xFB21, 0xF002), 0x8000_8000, 0x8000_8000, MIN, Q),  # smuad
        ((0xFB31, 0xF002), 0x0001_0000, 0x0000_0003, 3, 0),  # smulwb
        ((0xFB51, 0xF002), MIN, MIN, 0x4000_0000, 0),  # smmul
        ((0xFB51, 0xF012), 0x0001_8000, 0x0001_0000, 2, 0),  # smmulr
        ((0xFB71, 0xF002), 0x01FF_0310, 0xFF00_0301, 254 + 255 + 15, 0),  # usad8
    ],
)
def test_dsp(core, code, r1, r2, r0, flags):
    core.execute(*code, r1=r1, r2=r2)
    assert hex(core.r0) == hex(r0)
    assert core.xpsr & (GE | Q) == (flags if flags == Q else flags << 16)


@each("ge", range(16))
def test_sel(core, ge):
    core.execute(0xFAA1, 0xF082, r1=0x1111_1111, r2=0x2222_2222, xpsr=ge << 16)
    assert core.r0 == sum((0x11 if ge >> lane & 1 else 0x22) << 8 * lane for lane in range(4))


def test_long_products(core):
    core.execute(0xFBC2, 0x01C3, r0=ONES, r1=0, r2=0x0002_0003, r3=0x0004_0005)  # smlald r0, r1, r2, r3
    assert (core.r0, core.engine.get(Reg.R1)) == (22, 1)
    core.execute(0xFBE2, 0x0163, r0=ONES, r1=ONES, r2=ONES, r3=ONES)  # umaal: the largest there is
    assert (core.r0, core.engine.get(Reg.R1)) == (ONES, ONES)


# --- fixed point


@each("fpscr", [TO_NEAREST, UP, DOWN, TO_ZERO])
def test_fixed_point_becomes_single_by_rounding_to_nearest(core, fpscr):
    """Whatever FPSCR.RMode says: VCVT calls FixedToFP with round_to_nearest (chapter A7.7)."""
    assert core.execute(0xEEBA, 0x0AC8, singles=[0x0100_0001], fpscr=fpscr)[0] == single(2.0**24 / 2**16)
    assert core.execute(0xEEBA, 0x0AC8, singles=[0x0100_0003], fpscr=fpscr)[0] == single((2.0**24 + 4) / 2**16)
