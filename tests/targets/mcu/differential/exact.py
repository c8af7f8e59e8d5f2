"""Floating point by its definition: exact rational numbers, rounded as DDI0403 section A2.5 and IEEE 754 say.

Slow and plain, and written from the manual's pseudocode alone: an oracle for what the core does fast. Values are bits;
a status is FPSCR, whose cumulative flags are collected in `flags`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

IOC, DZC, OFC, UFC, IXC, IDC = 1 << 0, 1 << 1, 1 << 2, 1 << 3, 1 << 4, 1 << 7
FZ, DN, AHP = 1 << 24, 1 << 25, 1 << 26
NEAREST, UP, DOWN, ZERO, AWAY = range(5)


class Format(NamedTuple):
    """Widths in bits: of all, of the exponent, of the fraction."""

    width: int
    exponent: int
    fraction: int

    @property
    def most(self) -> int:
        """The exponent field of infinities and NaN."""
        return (1 << self.exponent) - 1

    @property
    def least(self) -> int:
        """The exponent of the smallest normal number."""
        return 2 - (1 << self.exponent - 1)

    def pack(self, sign: int, exponent: int, fraction: int) -> int:
        return sign << self.width - 1 | exponent << self.fraction | fraction

    def infinity(self, sign: int) -> int:
        return self.pack(sign, self.most, 0)

    @property
    def default_nan(self) -> int:
        return self.pack(0, self.most, 1 << self.fraction - 1)


HALF, SINGLE, DOUBLE = Format(16, 5, 10), Format(32, 8, 23), Format(64, 11, 52)


@dataclass(slots=True)
class Number:
    """What bits stand for (``FPUnpack``): kind is ``number``, ``infinity``, ``quiet`` or ``signalling``."""

    kind: str
    sign: int
    value: Fraction
    bits: int

    @property
    def is_zero(self) -> bool:
        return self.kind == "number" and self.value == 0


class Unit:
    """Operations of the pseudocode under one FPSCR.

    Attributes:
        flags: the cumulative ones that operations have set.
    """

    def __init__(self, status: int) -> None:
        self.status = status
        self.mode = status >> 22 & 3
        self.flags = 0

    def unpack(self, bits: int, fmt: Format) -> Number:
        sign = bits >> fmt.width - 1
        exponent, fraction = bits >> fmt.fraction & fmt.most, bits & (1 << fmt.fraction) - 1
        if exponent == fmt.most and not (fmt is HALF and self.status & AHP):
            if not fraction:
                return Number("infinity", sign, Fraction(0), bits)
            return Number("quiet" if fraction >> fmt.fraction - 1 else "signalling", sign, Fraction(0), bits)
        if exponent == 0 and fraction and fmt is not HALF and self.status & FZ:
            self.flags |= IDC
            fraction = 0
        mantissa = fraction | (1 << fmt.fraction if exponent else 0)
        value = mantissa * Fraction(2) ** (fmt.least + max(exponent, 1) - 1 - fmt.fraction)
        return Number("number", sign, -value if sign else value, bits)

    def _rounded(self, value: Fraction, mode: int) -> tuple[int, bool]:
        """Return an integer (of a magnitude, where `mode` was told the sign), and whether it is inexact."""
        down = math.floor(value)
        error = value - down
        half = Fraction(1, 2)
        up = {
            NEAREST: error > half or (error == half and down % 2 == 1),
            UP: error > 0,
            DOWN: False,
            ZERO: error > 0 and value < 0,
            AWAY: error > half or (error == half and value >= 0),
        }[mode]
        return down + up, error != 0

    def round(self, value: Fraction, fmt: Format, mode: int | None = None) -> int:
        """FPRound of a number that is not zero."""
        mode = self.mode if mode is None else mode
        sign, magnitude = int(value < 0), abs(value)
        exponent = magnitude.numerator.bit_length() - magnitude.denominator.bit_length()
        if magnitude < Fraction(2) ** exponent:
            exponent -= 1
        if self.status & FZ and fmt is not HALF and exponent < fmt.least:
            self.flags |= UFC
            return fmt.pack(sign, 0, 0)
        biased = max(exponent - fmt.least + 1, 0)
        scaled = magnitude / Fraction(2) ** (max(exponent, fmt.least) - fmt.fraction)
        toward = {UP: DOWN if sign else UP, DOWN: UP if sign else DOWN, ZERO: DOWN}.get(mode, mode)
        mantissa, inexact = self._rounded(scaled, toward)
        if not biased and inexact:
            self.flags |= UFC
        if not biased and mantissa == 1 << fmt.fraction:
            biased = 1
        if mantissa == 2 << fmt.fraction:
            biased, mantissa = biased + 1, mantissa >> 1
        if biased >= fmt.most and (biased > fmt.most or not (fmt is HALF and self.status & AHP)):
            return self._too_large(sign, fmt, to_infinity=toward in {NEAREST, UP, AWAY})
        if inexact:
            self.flags |= IXC
        return fmt.pack(sign, biased, mantissa & (1 << fmt.fraction) - 1)

    def _too_large(self, sign: int, fmt: Format, *, to_infinity: bool) -> int:
        last = (1 << fmt.fraction) - 1
        if fmt is HALF and self.status & AHP:
            self.flags |= IOC
            return fmt.pack(sign, fmt.most, last)
        self.flags |= OFC | IXC
        return fmt.infinity(sign) if to_infinity else fmt.pack(sign, fmt.most - 1, last)

    def _nan(self, nan: Number, fmt: Format) -> int:
        """FPProcessNaN"""
        if nan.kind == "signalling":
            self.flags |= IOC
        return fmt.default_nan if self.status & DN else nan.bits | 1 << fmt.fraction - 1

    def _nans(self, fmt: Format, *operands: Number) -> int | None:
        """FPProcessNaNs and FPProcessNaNs3"""
        for kind in ("signalling", "quiet"):
            for operand in operands:
                if operand.kind == kind:
                    return self._nan(operand, fmt)
        return None

    def _invalid(self, fmt: Format) -> int:
        self.flags |= IOC
        return fmt.default_nan

    def _sum(self, value: Fraction, sign: int | None, fmt: Format) -> int:
        """A sum, with the sign that a zero of two zeros alike has."""
        if value == 0:
            return fmt.pack(int(self.mode == DOWN) if sign is None else sign, 0, 0)
        return self.round(value, fmt)

    def add(self, one: int, two: int, fmt: Format, *, subtract: bool = False) -> int:
        a, b = self.unpack(one, fmt), self.unpack(two, fmt)
        if (nan := self._nans(fmt, a, b)) is not None:
            return nan
        sign = b.sign ^ subtract
        if a.kind == b.kind == "infinity" and a.sign != sign:
            return self._invalid(fmt)
        if "infinity" in {a.kind, b.kind}:
            return fmt.infinity(a.sign if a.kind == "infinity" else sign)
        alike = a.sign if a.is_zero and b.is_zero and a.sign == sign else None
        return self._sum(a.value - b.value if subtract else a.value + b.value, alike, fmt)

    def multiply(self, one: int, two: int, fmt: Format) -> int:
        a, b = self.unpack(one, fmt), self.unpack(two, fmt)
        if (nan := self._nans(fmt, a, b)) is not None:
            return nan
        if {a.kind, b.kind} == {"infinity", "number"} and (a.is_zero or b.is_zero):
            return self._invalid(fmt)
        sign = a.sign ^ b.sign
        if "infinity" in {a.kind, b.kind}:
            return fmt.infinity(sign)
        product = a.value * b.value
        return self.round(product, fmt) if product else fmt.pack(sign, 0, 0)

    def divide(self, one: int, two: int, fmt: Format) -> int:
        a, b = self.unpack(one, fmt), self.unpack(two, fmt)
        if (nan := self._nans(fmt, a, b)) is not None:
            return nan
        sign = a.sign ^ b.sign
        if a.kind == b.kind == "infinity" or (a.is_zero and b.is_zero):
            return self._invalid(fmt)
        if a.kind == "infinity":
            return fmt.infinity(sign)
        if b.is_zero:
            self.flags |= DZC
            return fmt.infinity(sign)
        if a.is_zero or b.kind == "infinity":
            return fmt.pack(sign, 0, 0)
        return self.round(a.value / b.value, fmt)

    def square_root(self, one: int, fmt: Format) -> int:
        a = self.unpack(one, fmt)
        if (nan := self._nans(fmt, a)) is not None:
            return nan
        if a.is_zero:
            return fmt.pack(a.sign, 0, 0)
        if a.sign:
            return self._invalid(fmt)
        if a.kind == "infinity":
            return fmt.infinity(0)
        # value * 4^k is an integer with over 120 bits more than its root needs
        places = 1100 + a.value.denominator.bit_length()
        whole = int(a.value * 4**places)
        root = math.isqrt(whole)
        exact = Fraction(root) if root * root == whole else Fraction(2 * root + 1, 2)
        return self.round(exact / 2**places, fmt)

    def fused(self, addend: int, one: int, two: int, fmt: Format) -> int:
        """FPMulAdd"""
        c, a, b = self.unpack(addend, fmt), self.unpack(one, fmt), self.unpack(two, fmt)
        nan = self._nans(fmt, c, a, b)
        impossible = (a.kind == "infinity" and b.is_zero) or (a.is_zero and b.kind == "infinity")
        if c.kind == "quiet" and impossible:
            return self._invalid(fmt)
        if nan is not None:
            return nan
        sign, infinite = a.sign ^ b.sign, "infinity" in {a.kind, b.kind}
        if impossible or (infinite and c.kind == "infinity" and c.sign != sign):
            return self._invalid(fmt)
        if infinite or c.kind == "infinity":
            return fmt.infinity(sign if infinite else c.sign)
        product = a.value * b.value
        alike = sign if c.is_zero and product == 0 and c.sign == sign else None
        return self._sum(c.value + product, alike, fmt)

    def extreme(self, one: int, two: int, fmt: Format, *, least: bool) -> int:
        """FPMaxNum and FPMinNum"""
        a, b = self.unpack(one, fmt), self.unpack(two, fmt)
        if a.kind == "quiet" and b.kind != "quiet":
            a = Number("infinity", int(not least), Fraction(0), 0)
        elif b.kind == "quiet" and a.kind != "quiet":
            b = Number("infinity", int(not least), Fraction(0), 0)
        if (nan := self._nans(fmt, a, b)) is not None:
            return nan
        if a.is_zero and b.is_zero:
            return fmt.pack(a.sign | b.sign if least else a.sign & b.sign, 0, 0)
        chosen = a if (self._order(a, b) < 0) == least else b
        if chosen.kind == "infinity":
            return fmt.infinity(chosen.sign)
        return fmt.pack(chosen.sign, 0, 0) if chosen.is_zero else self.round(chosen.value, fmt)

    @staticmethod
    def _order(a: Number, b: Number) -> int:
        huge = Fraction(2) ** 5000
        one, two = (
            (-huge if number.sign else huge) if number.kind == "infinity" else number.value for number in (a, b)
        )
        return (one > two) - (one < two)

    def compare(self, one: int, two: int, fmt: Format, *, quiet_is_invalid: bool) -> int:
        """FPCompare: NZCV"""
        a, b = self.unpack(one, fmt), self.unpack(two, fmt)
        if {a.kind, b.kind} & {"quiet", "signalling"}:
            if quiet_is_invalid or "signalling" in {a.kind, b.kind}:
                self.flags |= IOC
            return 0b0011
        return {0: 0b0110, -1: 0b1000, 1: 0b0010}[self._order(a, b)]

    def to_integral(self, one: int, fmt: Format, mode: int, *, tells_inexact: bool) -> int:
        """FPRoundInt"""
        a = self.unpack(one, fmt)
        if (nan := self._nans(fmt, a)) is not None:
            return nan
        if a.kind == "infinity":
            return fmt.infinity(a.sign)
        whole, inexact = self._rounded(a.value, mode)
        if inexact and tells_inexact:
            self.flags |= IXC
        return self.round(Fraction(whole), fmt) if whole else fmt.pack(a.sign, 0, 0)

    def to_fixed(self, one: int, fmt: Format, bits: int, places: int, mode: int, *, unsigned: bool) -> int:
        """FPToFixed: an integer of so many bits, as 32"""
        a = self.unpack(one, fmt)
        low, high = (0, (1 << bits) - 1) if unsigned else (-(1 << bits - 1), (1 << bits - 1) - 1)
        if a.kind in {"quiet", "signalling"}:
            self.flags |= IOC
            return 0
        if a.kind == "infinity":
            self.flags |= IOC
            return (low if a.sign else high) & 0xFFFF_FFFF
        whole, inexact = self._rounded(a.value * 2**places, mode)
        if not low <= whole <= high:
            self.flags |= IOC
            return (low if whole < low else high) & 0xFFFF_FFFF
        if inexact:
            self.flags |= IXC
        return whole & 0xFFFF_FFFF

    def from_fixed(self, whole: int, places: int, fmt: Format, mode: int | None = None) -> int:
        """FixedToFP"""
        return self.round(Fraction(whole, 1 << places), fmt, mode) if whole else 0

    def convert(self, one: int, source: Format, target: Format) -> int:
        """Between formats: FPSingleToDouble, FPDoubleToSingle, FPHalfToSingle and their kin."""
        a = self.unpack(one, source)
        alternative = target is HALF and bool(self.status & AHP)
        if a.kind in {"quiet", "signalling"}:
            if alternative:
                self.flags |= IOC
                return target.pack(a.sign, 0, 0)
            quieted = self._nan(a, source)
            fraction = quieted & (1 << source.fraction) - 1
            shift = target.fraction - source.fraction
            sign = quieted >> source.width - 1
            return target.pack(sign, target.most, fraction << shift if shift > 0 else fraction >> -shift)
        if a.kind == "infinity":
            if alternative:
                self.flags |= IOC
                return target.pack(a.sign, target.most, (1 << target.fraction) - 1)
            return target.infinity(a.sign)
        return self.round(a.value, target) if a.value else target.pack(a.sign, 0, 0)


def negated(bits: int, fmt: Format) -> int:
    """FPNeg"""
    return bits ^ 1 << fmt.width - 1


class Operation(NamedTuple):
    """An instruction on d0, d1, d2, or s0, s2, s4.

    Attributes:
        name: for people.
        code: both halves.
        result: what becomes of D0, and in comparisons of NZCV, by the bits of the three registers of 64 bits.
        inputs: the formats of the three registers; None is an integer.
    """

    name: str
    code: tuple[int, int]
    result: Callable[[Unit, int, int, int], tuple[int, int]]
    inputs: tuple[Format | None, Format | None, Format | None]


def _low(d0: int, bits: int, fmt: Format) -> int:
    """D0 with a result of some format in its lower end."""
    return d0 & ~((1 << fmt.width) - 1) | bits if fmt is not DOUBLE else bits


def _take(bits: int, fmt: Format) -> int:
    return bits & (1 << fmt.width) - 1


Binary = Callable[[Unit, int, int, int, Format], int]

_THREE: dict[str, tuple[int, int, Binary]] = {
    "vmla": (0xEE00, 0, lambda u, d, n, m, f: u.add(d, u.multiply(n, m, f), f)),
    "vmls": (0xEE00, 1, lambda u, d, n, m, f: u.add(d, negated(u.multiply(n, m, f), f), f)),
    "vnmls": (0xEE10, 0, lambda u, d, n, m, f: u.add(negated(d, f), u.multiply(n, m, f), f)),
    "vnmla": (0xEE10, 1, lambda u, d, n, m, f: u.add(negated(d, f), negated(u.multiply(n, m, f), f), f)),
    "vmul": (0xEE20, 0, lambda u, _, n, m, f: u.multiply(n, m, f)),
    "vnmul": (0xEE20, 1, lambda u, _, n, m, f: negated(u.multiply(n, m, f), f)),
    "vadd": (0xEE30, 0, lambda u, _, n, m, f: u.add(n, m, f)),
    "vsub": (0xEE30, 1, lambda u, _, n, m, f: u.add(n, m, f, subtract=True)),
    "vdiv": (0xEE80, 0, lambda u, _, n, m, f: u.divide(n, m, f)),
    "vfnms": (0xEE90, 0, lambda u, d, n, m, f: u.fused(negated(d, f), n, m, f)),
    "vfnma": (0xEE90, 1, lambda u, d, n, m, f: u.fused(negated(d, f), negated(n, f), m, f)),
    "vfma": (0xEEA0, 0, lambda u, d, n, m, f: u.fused(d, n, m, f)),
    "vfms": (0xEEA0, 1, lambda u, d, n, m, f: u.fused(d, negated(n, f), m, f)),
    "vmaxnm": (0xFE80, 0, lambda u, _, n, m, f: u.extreme(n, m, f, least=False)),
    "vminnm": (0xFE80, 1, lambda u, _, n, m, f: u.extreme(n, m, f, least=True)),
}
_SIGN_OPERATIONS: dict[str, tuple[int, int, Callable[[int, Format], int]]] = {
    "vmov": (0xEEB0, 0x40, lambda m, _: m),
    "vabs": (0xEEB0, 0xC0, lambda m, f: m & ~(1 << f.width - 1)),
    "vneg": (0xEEB1, 0x40, negated),
}
_BY_NAME = {"a": AWAY, "n": NEAREST, "p": UP, "m": DOWN}


def _in_place(fmt: Format, compute: Callable[[Unit, int], int]) -> Callable[[Unit, int, int, int], tuple[int, int]]:
    return lambda u, d, _n, m: (_low(d, compute(u, m), fmt), 0)


def _three(fmt: Format, compute: Binary) -> Callable[[Unit, int, int, int], tuple[int, int]]:
    return lambda u, d, n, m: (_low(d, compute(u, _take(d, fmt), _take(n, fmt), _take(m, fmt), fmt), fmt), 0)


def _compare(fmt: Format, *, zero: bool, strict: bool) -> Callable[[Unit, int, int, int], tuple[int, int]]:
    return lambda u, d, _n, m: (
        d,
        u.compare(_take(d, fmt), 0 if zero else _take(m, fmt), fmt, quiet_is_invalid=strict),
    )


def _signed(word: int, bits: int) -> int:
    word &= (1 << bits) - 1
    return word - (1 << bits) if word >> bits - 1 else word


def _fixed(fmt: Format, *, to: bool, unsigned: bool, bits: int, places: int) -> Callable[..., tuple[int, int]]:
    def to_fixed(u: Unit, d: int, _n: int, _m: int) -> tuple[int, int]:
        result = u.to_fixed(_take(d, fmt), fmt, bits, places, ZERO, unsigned=unsigned)
        if fmt is DOUBLE and not unsigned:
            result = _signed(result, 32) & (1 << 64) - 1
        return _low(d, result, fmt), 0

    def from_fixed(u: Unit, d: int, _n: int, _m: int) -> tuple[int, int]:
        whole = d & (1 << bits) - 1 if unsigned else _signed(d, bits)
        return _low(d, u.from_fixed(whole, places, fmt, NEAREST), fmt), 0

    return to_fixed if to else from_fixed


Inputs = tuple[Format | None, Format | None, Format | None]
Row = tuple[str, int, int, Callable[..., tuple[int, int]], Inputs]


def _arithmetic(fmt: Format) -> Iterator[Row]:
    two, three = (None, None, fmt), (fmt, fmt, fmt)
    for name, (first, op, compute) in _THREE.items():
        yield name, first | 1, op << 6 | 2, _three(fmt, compute), three
    for name, (first, second, change) in _SIGN_OPERATIONS.items():
        yield name, first, second | 2, _in_place(fmt, lambda _u, m, c=change: c(_take(m, fmt), fmt)), two
    yield "vsqrt", 0xEEB1, 0xC2, _in_place(fmt, lambda u, m: u.square_root(_take(m, fmt), fmt)), two
    for strict in (False, True):
        e = "e" if strict else ""
        yield f"vcmp{e}", 0xEEB4, 0x42 | strict << 7, _compare(fmt, zero=False, strict=strict), three
        yield f"vcmp{e} 0", 0xEEB5, 0x40 | strict << 7, _compare(fmt, zero=True, strict=strict), three


def _integral(fmt: Format) -> Iterator[Row]:
    ways = {"r": (0xEEB6, 0x42, None, False), "z": (0xEEB6, 0xC2, ZERO, False), "x": (0xEEB7, 0x42, None, True)}
    ways |= {name: (0xFEB8 | at, 0x42, mode, False) for at, (name, mode) in enumerate(_BY_NAME.items())}
    for name, (first, second, mode, tells) in ways.items():

        def rint(u: Unit, m: int, mode: int | None = mode, tells: bool = tells) -> int:
            return u.to_integral(_take(m, fmt), fmt, u.mode if mode is None else mode, tells_inexact=tells)

        yield f"vrint{name}", first, second, _in_place(fmt, rint), (None, None, fmt)


def _integers(fmt: Format, *, unsigned: bool) -> Iterator[Row]:
    kind, signed = ("u32", 0) if unsigned else ("s32", 1)
    ways = {"": (0xEEBC | signed, 0xC2, ZERO), "r": (0xEEBC | signed, 0x42, None)}
    ways |= {name: (0xFEBC | at, 0x42 | signed << 7, mode) for at, (name, mode) in enumerate(_BY_NAME.items())}
    for name, (first, second, mode) in ways.items():

        def to_int(u: Unit, m: int, mode: int | None = mode) -> int:
            return u.to_fixed(_take(m, fmt), fmt, 32, 0, u.mode if mode is None else mode, unsigned=unsigned)

        yield f"vcvt{name}.{kind}", first, second, _in_place(SINGLE, to_int), (None, None, fmt)

    def from_int(u: Unit, m: int) -> int:
        return u.from_fixed(m & 0xFFFF_FFFF if unsigned else _signed(m, 32), 0, fmt)

    yield f"vcvt from {kind}", 0xEEB8, 0x42 | signed << 7, _in_place(fmt, from_int), (None, None, None)


def _fixed_points(fmt: Format, *, unsigned: bool) -> Iterator[Row]:
    for bits, places in ((16, 0), (16, 5), (16, 16), (32, 1), (32, 16), (32, 32)):
        constant = bits - places
        second = (bits == 32) << 7 | (constant & 1) << 5 | constant >> 1 | 0x40
        kind = f"{'u' if unsigned else 's'}{bits} #{places}"
        from_ = _fixed(fmt, to=False, unsigned=unsigned, bits=bits, places=places)
        yield f"vcvt from {kind}", 0xEEBA | unsigned, second, from_, (None, None, None)
        to = _fixed(fmt, to=True, unsigned=unsigned, bits=bits, places=places)
        yield f"vcvt to {kind}", 0xEEBE | unsigned, second, to, (fmt, None, None)


def _formats(fmt: Format) -> Iterator[Row]:
    for top, name in enumerate(("vcvtb", "vcvtt")):

        def from_half(u: Unit, m: int, top: int = top) -> int:
            return u.convert(m >> 16 * top & 0xFFFF, HALF, fmt)

        def to_half(u: Unit, d: int, _n: int, m: int, top: int = top) -> tuple[int, int]:
            half = u.convert(_take(m, fmt), fmt, HALF)
            return d & ~(0xFFFF << 16 * top) | half << 16 * top, 0

        yield f"{name} from half", 0xEEB2, 0x42 | top << 7, _in_place(fmt, from_half), (None, None, HALF)
        yield f"{name} to half", 0xEEB3, 0x42 | top << 7, to_half, (None, None, fmt)
    other = SINGLE if fmt is DOUBLE else DOUBLE
    change = _in_place(other, lambda u, m: u.convert(_take(m, fmt), fmt, other))
    yield "vcvt size", 0xEEB7, 0xC2, change, (None, None, fmt)


def _of_format(fmt: Format, letters: str, size: int) -> Iterator[Operation]:
    rows = [*_arithmetic(fmt), *_integral(fmt), *_formats(fmt)]
    for unsigned in (False, True):
        rows += [*_integers(fmt, unsigned=unsigned), *_fixed_points(fmt, unsigned=unsigned)]
    for name, first, second, result, inputs in rows:
        yield Operation(f"{name}.{letters}", (first, 0xA00 | size << 8 | second), result, inputs)


OPERATIONS = (*_of_format(SINGLE, "f32", 0), *_of_format(DOUBLE, "f64", 1))
