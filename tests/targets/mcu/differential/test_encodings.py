"""What the core decodes, against the table of encodings, which was written from the manual and not from ``isa.h``.

All half-words as instructions of 16 bits, random ones of 32 bits, and a few of each encoding.
"""

from __future__ import annotations

import random
import re
import struct

import pytest

from targets.mcu.core.sources import SOURCES
from targets.mcu.cortexm.kinds import CORTEX_M3, CORTEX_M7
from targets.mcu.engine.api import FaultKind, Reg
from targets.mcu.engine.core_engine import CoreEngine
from targets.mcu.engine.timing import make_timing
from tests.each import each
from tests.targets.mcu.differential import encodings, encodings_m7
from tests.targets.mcu.differential.encodings import parse

FLASH, RAM = 0x0800_0000, 0x2000_0000
NOP = 0xBF00
SLOT = 8
DECODERS = {"M3": encodings.decode, "M7": encodings_m7.decode}
KINDS = {"M3": CORTEX_M3, "M7": CORTEX_M7}
ENCODINGS = {"M3": encodings.ENCODINGS, "M7": encodings.ENCODINGS + encodings_m7.ENCODINGS}
UNDEFINED = ("UDF T1", "UDF T2")

_ROW = re.compile(r'(FLOAT_)?ROW\("([01a-z -]+)",[^)]*?(BASE|DSP|FP|, \d+),[^)]*\)')

# What the table does not have and the core executes all the same, as the manual allows.
MORE = """
16 bits: reserved hints execute as NOP (A5.2.5)
reserved hints                   10111111....0000

32 bits: UNPREDICTABLE, for bits that the manual has in parentheses are not what they should be
SDIV                             111110111001.... ........1111....
UDIV                             111110111011.... ........1111....

32 bits: the same, of a Cortex-M7 alone
PKHBT, PKHTB                     111010101100.... ...........0....
VMOV to and from core, single    11101110000..... ....1010...1....
VMOV, half of double             1110111000...... ....1011.001....
VMSR                             1110111011100001 ....1010...1....
VMRS                             1110111011110001 ....1010...1....
VMOV (immediate)                 111011101.11.... ....101..0.0....
VCMP, VCMPE with zero            111011101.110101 ....101..1.0....
"""
ALSO_EXECUTED = tuple(parse(MORE))

# What the core has as UNDEFINED though the table has it: UNPREDICTABLE, for the list of registers is empty.
EMPTY_LISTS = {0xB400, 0xBC00, *range(0xC000, 0xC800, 0x100), *range(0xC800, 0xD000, 0x100)}


def undefined(codes, kind):
    """Say for each instruction, two halves, whether the core has it as UNDEFINED."""
    flash = bytearray(b"".join(struct.pack("<4H", *halves, NOP, NOP) for halves in codes))
    flash += bytes(-len(flash) % 0x400)
    engine = CoreEngine(make_timing("flat", kind), kind)
    engine.map_memory(FLASH, flash, writable=False)
    engine.map_memory(RAM, bytearray(0x1000), writable=True)
    for register in list(Reg)[:14]:
        engine.set(register, RAM + 0x800)

    def is_undefined(place):
        engine.set(Reg.CONTROL, 0)
        engine.set(Reg.XPSR, 1 << 24)
        engine.set(Reg.PC, place)
        return engine.run(1 << 60, 1).fault is FaultKind.UNDEFINED and engine.get(Reg.PC) == place

    return [is_undefined(FLASH + SLOT * number) for number in range(len(codes))]


def shown(codes):
    return [" ".join(f"{half:04X}" for half in halves) for halves in codes]


def is_in_more(first, second, model):
    wide = encodings.is_wide(first)
    code = first << 16 | second if wide else first
    return any(
        (more.mask > 0xFFFF) == wide and code & more.mask == more.value and (model == "M7" or "M7" not in more.group)
        for more in ALSO_EXECUTED
    )


def filled(encoding, decode, rng, count):
    """Instructions of an encoding and no other, their fields random: any, and such that registers are low."""
    found = []
    for keep in (0xFFFF_FFFF, 0x7777_7777, 0xFFFF_170F) * count:
        code = encoding.value | rng.getrandbits(32) & keep & ~encoding.mask
        halves = (code >> 16, code & 0xFFFF) if encoding.mask > 0xFFFF else (code & 0xFFFF, NOP)
        if decode(*halves) is encoding:
            found.append(halves)
    return found


@each("model", KINDS)
def test_every_encoding_is_executed_by_the_core_that_has_it(model):
    rng = random.Random(1)
    codes = {encoding.name: filled(encoding, DECODERS[model], rng, 5) for encoding in ENCODINGS[model]}
    verdicts = iter(undefined([halves for some in codes.values() for halves in some], KINDS[model]))
    executed = {name: [not next(verdicts) for _ in some] for name, some in codes.items()}
    assert [name for name, which in executed.items() if not any(which)] == list(UNDEFINED)


def test_an_m3_has_nothing_of_what_an_m7_has_besides():
    rng, codes = random.Random(1), []
    for encoding in encodings_m7.ENCODINGS:
        codes += filled(encoding, encodings_m7.decode, rng, 2)
    codes = [halves for halves in codes if encodings.decode(*halves) is None]
    assert len(codes) > len(encodings_m7.ENCODINGS)
    verdicts = undefined(codes, CORTEX_M3)
    assert not shown(halves for halves, is_undefined in zip(codes, verdicts, strict=True) if not is_undefined)


def rows_of_the_core():
    """Return length, mask, value, what the core must have, and the text of each row of ``isa.h``."""
    for match in _ROW.finditer((SOURCES / "isa.h").read_text(encoding="utf-8")):
        floats, pattern, where = match.groups()
        bits = pattern.replace(" ", "")
        mask = int("".join("1" if bit in "01" else "0" for bit in bits), 2)
        value = int("".join("1" if bit == "1" else "0" for bit in bits), 2)
        yield len(bits), mask, value, "FP" if floats else where, match.group()


def test_no_row_of_the_core_hides_behind_another():
    """Each is the first that fits some instruction, which the table has as well."""
    rng, rows = random.Random(1), list(rows_of_the_core())
    assert len(rows) > 250

    def comes_first(row):
        length, mask, value, where, _ = row
        decode = DECODERS["M3" if where == "BASE" else "M7"]
        having = [other for other in rows if other[0] == length and other[3] in ("BASE", where)]
        for _ in range(200):
            code = value | rng.getrandbits(length) & ~mask
            if next(other for other in having if code & other[1] == other[2]) is row:
                halves = (code >> 16, code & 0xFFFF) if length == 32 else (code, NOP)
                if decode(*halves) is not None:
                    return True
        return False

    assert [row[4] for row in rows if not comes_first(row)] == []


@each(("model", "begin", "step"), [("M3", 0, 2), ("M3", 1, 2), ("M7", 0, 7)])
def test_all_of_16_bits(model, begin, step):
    """Both cores have the same of them, so of one of them a part will do."""
    codes = [(half, NOP) for half in range(begin, 0x1_0000, step) if not encodings.is_wide(half)]
    wrong = []
    for halves, is_undefined in zip(codes, undefined(codes, KINDS[model]), strict=True):
        encoding = encodings.decode(*halves)
        expected = encoding is None or encoding.name in UNDEFINED or halves[0] in EMPTY_LISTS
        if is_undefined != (expected and not is_in_more(*halves, model)):
            wrong.append(halves)
    assert not shown(wrong)


def check_wide(model, seed, count):
    rng = random.Random(seed)
    codes = [(rng.randrange(0xE800, 0x1_0000), rng.getrandbits(16)) for _ in range(count)]
    codes = [halves for halves in codes if DECODERS[model](*halves) is None and not is_in_more(*halves, model)]
    assert len(codes) > count // 4
    verdicts = undefined(codes, KINDS[model])
    assert not shown(halves for halves, is_undefined in zip(codes, verdicts, strict=True) if not is_undefined)


@each("model", KINDS)
def test_what_fits_none_is_undefined(model):
    check_wide(model, 1, 5000)


@pytest.mark.exhaustive("two million random instructions; the gate has five thousand for each core")
@pytest.mark.parametrize("seed", range(2, 12))
@pytest.mark.parametrize("model", KINDS)
def test_whatever_fits_none_is_undefined(model, seed):
    check_wide(model, seed, 100_000)
