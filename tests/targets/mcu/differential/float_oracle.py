"""Executes one floating-point instruction over many operands: on our Cortex-M7, on Unicorn's, and by `exact`.

What is compared is D0, FPSCR with its cumulative flags, and NZCV.
"""

from __future__ import annotations

import itertools
import random
import struct
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from targets.mcu.cortexm.kinds import CORTEX_M7
from targets.mcu.engine.api import Reg, StopKind
from targets.mcu.engine.core_engine import CoreEngine
from targets.mcu.engine.timing import make_timing
from tests.targets.mcu.differential import oracle
from tests.targets.mcu.differential.exact import DOUBLE, HALF, OPERATIONS, SINGLE, Format, Operation, Unit
from tests.targets.mcu.differential.image import FLASH, RAM

START = FLASH + 0x100
AT_ONCE = 1000  # operands of 32 bytes, results of 16: in 64 KB of RAM
RESULTS = RAM + 32 * AT_ONCE
MODES = [rounding << 22 | fz << 24 | dn << 25 for rounding in range(4) for fz in range(2) for dn in range(2)]
AHP = 1 << 26
FLAGS = 0x9F


class Operands(NamedTuple):
    """FPSCR, and D0 to D2 as bits."""

    status: int
    d0: int
    d1: int
    d2: int


class Result(NamedTuple):
    """D0 as bits; NZCV and the cumulative flags of FPSCR."""

    d0: int
    flags: int


def code_of(operation: Operation) -> bytes:
    """R0: operands, R1: results, R2: how many. The rest of FPSCR must be as it was."""
    halves = [
        *(0x6803, 0x3008),  # ldr r3, [r0]; adds r0, #8
        *(0xECB0, 0x0B06),  # vldmia r0!, {d0-d2}
        *(0xEEE1, 0x3A10),  # vmsr fpscr, r3
        *operation.code,
        *(0xEEF1, 0x3A10),  # vmrs r3, fpscr
        *(0xECA1, 0x0B02),  # vstmia r1!, {d0}
        *(0x600B, 0x3108),  # str r3, [r1]; adds r1, #8
        0x3A01,  # subs r2, #1
    ]
    back = -(len(halves) + 2)
    halves += [0xD100 | back & 0xFF, 0xBE00]  # bne; bkpt
    return b"\xff" * (START - FLASH) + struct.pack(f"<{len(halves)}H", *halves)


def _packed(operands: Sequence[Operands]) -> bytes:
    return b"".join(struct.pack("<IIQQQ", status, 0, *bits) for status, *bits in operands)


def _results(data: bytes, operands: Sequence[Operands]) -> list[Result]:
    made = []
    for (d0, status, _), given in zip(struct.iter_unpack("<QII", data), operands, strict=True):
        kept = ~(0xF << 28 | FLAGS)
        assert status & kept == given.status & kept, f"FPSCR 0x{given.status:08X} became 0x{status:08X}"
        made.append(Result(d0, status & (0xF << 28 | FLAGS)))
    return made


def ours(operation: Operation, operands: Sequence[Operands]) -> list[Result]:
    """Return what our core makes of the operands, at most `AT_ONCE`."""
    engine, ram = CoreEngine(make_timing("flat", CORTEX_M7), CORTEX_M7), bytearray(0x1_0000)
    engine.map_memory(FLASH, bytearray(code_of(operation).ljust(0x400, b"\xff")), writable=False)
    engine.map_memory(RAM, ram, writable=True)
    data = _packed(operands)
    ram[: len(data)] = data
    for register, value in ((Reg.R0, RAM), (Reg.R1, RESULTS), (Reg.R2, len(operands)), (Reg.PC, START)):
        engine.set(register, value)
    engine.set(Reg.XPSR, 1 << 24)
    assert engine.run(1 << 40).kind is StopKind.BREAKPOINT
    return _results(bytes(ram[RESULTS - RAM : RESULTS - RAM + 16 * len(operands)]), operands)


def unicorns(operation: Operation, operands: Sequence[Operands]) -> list[Result]:
    """Return what Unicorn makes of them."""
    from unicorn import arm_const

    core = oracle.Core("M7", code_of(operation))
    core.uc.mem_write(RAM, _packed(operands))
    registers = (arm_const.UC_ARM_REG_R0, arm_const.UC_ARM_REG_R1, arm_const.UC_ARM_REG_R2)
    for register, value in zip(registers, (RAM, RESULTS, len(operands)), strict=True):
        core.uc.reg_write(register, value)
    core.run(START)
    return _results(bytes(core.uc.mem_read(RESULTS, 16 * len(operands))), operands)


def exactly(operation: Operation, given: Operands) -> Result:
    """Return what the definition makes of one."""
    unit = Unit(given.status)
    d0, nzcv = operation.result(unit, given.d0, given.d1, given.d2)
    kept = given.status & 0xF << 28
    return Result(d0, (nzcv << 28 if "vcmp" in operation.name else kept) | unit.flags)


# --- operands


def _edges(fmt: Format) -> list[int]:
    """Numbers at which something changes, of both signs."""
    one = fmt.most >> 1
    last = (1 << fmt.fraction) - 1
    fields = [
        *((0, 0), (0, 1), (0, 2), (0, last >> 1), (0, last), (1, 0), (1, 1), (2, 0)),
        *((one, 0), (one, 1), (one, last), (one - 1, 0), (one - 1, 1), (one - 1, last), (one + 1, 0)),
        *((one, 1 << fmt.fraction - 1), (one + fmt.fraction, 0), (one + fmt.fraction, 1), (one + fmt.fraction, last)),
        *((one - fmt.fraction, 0), (one - fmt.fraction - 1, 0), (one - fmt.fraction - 1, 1)),
        *((fmt.most - 1, 0), (fmt.most - 1, last), (fmt.most, 0)),
        *((fmt.most, 1), (fmt.most, last >> 1), (fmt.most, last + 1 >> 1), (fmt.most, last)),
    ]
    for exponent in (15, 16, 30, 31, 32):  # of integers
        fields += [(one + exponent, fraction) for fraction in (0, 1, last) if one + exponent < fmt.most]
    return [fmt.pack(sign, *field) for sign in (0, 1) for field in fields]


def _next_to_squares(count: int) -> list[int]:
    """Return doubles whose roots are inexact by less than 2^-62: many zeros, and a rest, follow the last bit."""
    rng, made = random.Random("squares"), list[int]()
    while len(made) < count:
        whole = (rng.getrandbits(DOUBLE.fraction) | 1 << DOUBLE.fraction) ** 2
        below = whole.bit_length() - DOUBLE.fraction - 1
        rest = -whole & (1 << below) - 1
        if 0 < rest < 1 << below - 11:
            odd = (whole.bit_length() - 1) & 1
            mantissa = (whole + rest) >> below
            made.append(DOUBLE.pack(0, (DOUBLE.most >> 1) + odd, mantissa & (1 << DOUBLE.fraction) - 1))
    return made


EDGES = {HALF: _edges(HALF), SINGLE: _edges(SINGLE), DOUBLE: [*_edges(DOUBLE), *_next_to_squares(8)]}
_WORDS = [0, 1, 2, 0x7FFF, 0x8000, 0xFFFF, 0x1_0000, 0x100_0001, 0x7FFF_FFFF, 0x8000_0000, 0xFFFF_FFFF, 0xFFFF_FF7F]


def _number(rng: random.Random, fmt: Format, near: int | None) -> int:
    """Return bits: at an edge, anything, with few bits set, or with an exponent near that of another number."""
    kind = rng.randrange(5)
    if kind == 0:
        return rng.choice(EDGES[fmt])
    if kind == 1:
        return rng.getrandbits(fmt.width)
    if near is not None and kind == 2:
        exponent = (near >> fmt.fraction & fmt.most) + rng.randint(-fmt.fraction - 3, fmt.fraction + 3)
    else:
        exponent = (fmt.most >> 1) + rng.randint(-fmt.fraction - 2, fmt.fraction + 2)
    fraction = rng.getrandbits(fmt.fraction)
    if rng.random() < 0.5:  # half-way cases
        fraction &= ~((1 << rng.randrange(fmt.fraction)) - 1)
    return fmt.pack(rng.getrandbits(1), min(max(exponent, 0), fmt.most), fraction)


def _word(rng: random.Random) -> int:
    kind = rng.randrange(3)
    return (
        rng.choice(_WORDS) if kind == 0 else rng.getrandbits(32) if kind == 1 else rng.getrandbits(rng.randint(1, 32))
    )


def _register(rng: random.Random, fmt: Format | None, near: int | None) -> int:
    """Return 64 bits; above what counts is anything."""
    anything = rng.getrandbits(64)
    if fmt is None:
        return anything & ~0xFFFF_FFFF | _word(rng)
    if fmt is HALF:
        return anything & ~0xFFFF_FFFF | _number(rng, HALF, None) << 16 | _number(rng, HALF, None)
    return anything & ~((1 << fmt.width) - 1) | _number(rng, fmt, near)


def random_operands(operation: Operation, rng: random.Random, count: int) -> list[Operands]:
    """Return operands and modes that meet each other's edges."""
    made = []
    for _ in range(count):
        d0, d1, d2 = operation.inputs
        two = _register(rng, d2, None)
        one = _register(rng, d1, two)
        zero = _register(rng, d0, one)
        if d0 is not None and d0 is d1 and rng.random() < 0.2:  # an addend that a product may cancel
            zero = _cancelling(rng, zero, one, two, d0)
        made.append(Operands(_status(rng), zero, one, two))
    return made


def _cancelling(rng: random.Random, zero: int, one: int, two: int, fmt: Format) -> int:
    product = Unit(rng.randrange(4) << 22).multiply(one & (1 << fmt.width) - 1, two & (1 << fmt.width) - 1, fmt)
    return zero & ~((1 << fmt.width) - 1) | product ^ rng.getrandbits(1) << fmt.width - 1


def _status(rng: random.Random) -> int:
    return rng.choice(MODES) | (AHP if rng.random() < 0.25 else 0) | rng.getrandbits(4) << 28


def special_operands(operation: Operation) -> Iterator[Operands]:
    """Every pair of special values in every mode; a third operand goes round."""
    first, second = (specials(fmt) for fmt in operation.inputs[1:])
    addends = specials(operation.inputs[0])
    turn = 0
    for mode in (*MODES, AHP, AHP | 1 << 24):
        for one in first if operation.inputs[1] is not None else [0]:
            for two in second:
                turn += 7
                yield Operands(mode, addends[turn % len(addends)], one, two)


def corner_operands(operation: Operation) -> Iterator[Operands]:
    """All triples of kinds of numbers for what is fused; for one operand, each special value."""
    d0, d1, d2 = operation.inputs
    if operation.name.startswith("vf") and d2 is not None:
        one = d2.pack(0, d2.most >> 1, 0)
        nans = d2.infinity(0) | 1, d2.infinity(1) | d2.default_nan | 1
        kinds = (0, d2.pack(1, 0, 0), one, d2.infinity(0), d2.infinity(1), *nans)
        yield from (Operands(0, *triple) for triple in itertools.product(kinds, repeat=3))
    elif d1 is None:
        changes = specials(d0 if d2 is None else d2)
        modes = (0, AHP) if "half" in operation.name else (0,)
        yield from (Operands(mode, bits, 0, bits) for mode in modes for bits in changes)


def specials(fmt: Format | None) -> list[int]:
    """Return the special values of a register of that format."""
    if fmt is None:
        return _WORDS
    return [bits << 16 | bits for bits in EDGES[HALF]] if fmt is HALF else EDGES[fmt]


# --- comparison


def problems(operation: Operation, operands: Sequence[Operands], *, by_definition: bool, by_unicorn: bool) -> list[str]:
    """Return where ours differs from what is asked for."""
    told = []
    for start in range(0, len(operands), AT_ONCE):
        part = operands[start : start + AT_ONCE]
        mine = ours(operation, part)
        theirs = {}
        if by_definition:
            theirs["definition"] = [exactly(operation, given) for given in part]
        if by_unicorn:
            theirs["Unicorn"] = unicorns(operation, part)
        for name, results in theirs.items():
            for given, expected, actual in zip(part, results, mine, strict=True):
                if expected != actual and not (name == "Unicorn" and _is_known(operation, given)):
                    told.append(_told(name, operation, given, expected, actual))
    return told


def _told(name: str, operation: Operation, given: Operands, expected: Result, actual: Result) -> str:
    registers = " ".join(f"d{number}={bits:016x}" for number, bits in enumerate(given[1:]))
    return (
        f"{operation.name}, FPSCR {given.status:08x}, {registers}: d0={expected.d0:016x} FPSCR {expected.flags:08x} by "
        f"{name}, d0={actual.d0:016x} FPSCR {actual.flags:08x} ours"
    )


def _is_known(operation: Operation, given: Operands) -> bool:
    """An error of Unicorn: it rounds by FPSCR where the manual says to nearest (see `oracle.KNOWN`)."""
    return (
        operation.name.startswith(("vcvt from s", "vcvt from u"))
        and "#" in operation.name
        and bool(given.status & 3 << 22)
    )


BY_NAME = {operation.name: operation for operation in OPERATIONS}
