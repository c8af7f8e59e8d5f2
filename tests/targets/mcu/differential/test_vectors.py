"""The CPU engine against the architecture manual: results worked out by hand from the pseudo-code of DDI0403.

What stands here comes from no emulator. Flags are written as ``NZCVQ``, a capital for a flag that is set.
"""

from __future__ import annotations

import struct

import pytest

from targets.mcu.engine.api import Reg
from targets.mcu.engine.core_engine import CoreEngine
from targets.mcu.engine.timing import make_timing
from tests.each import each

CODE, RAM = 0x0800_0100, 0x2000_0000
NOP = 0xBF00
MAX, MIN, ONES = 0x7FFF_FFFF, 0x8000_0000, 0xFFFF_FFFF


class Core:
    """An engine with some flash and some RAM; executes a few instructions at a time."""

    def __init__(self):
        self.engine = CoreEngine(make_timing("flat"))
        self.flash, self.ram = bytearray(0x400), bytearray(0x400)
        self.engine.map_memory(CODE & ~0xFFF, self.flash, writable=False)
        self.engine.map_memory(RAM, self.ram, writable=True)

    def execute(self, *halves, flags="nzcvq", instructions=None, **registers):
        """Execute from `CODE` on; unnamed registers are 0. `instructions`: as many as there are, if not said."""
        engine, count = self.engine, instructions or _count(halves)
        code = struct.pack(f"<{len(halves)}H", *halves)
        self.flash[0x100 : 0x100 + len(code) + 64] = code + b"\x00\xbf" * 32
        engine.forget(CODE & ~0xFFF, len(self.flash))
        for register in list(Reg)[:15]:
            engine.set(register, registers.get(register.name.lower(), 0))
        bits = sum((letter.isupper()) << 31 - place for place, letter in enumerate(flags))
        engine.set(Reg.XPSR, 1 << 24 | bits)
        engine.set(Reg.PC, CODE)
        engine.run(1 << 40, count)

    @property
    def flags(self):
        xpsr = self.engine.get(Reg.XPSR)
        return "".join(letter if xpsr >> 31 - place & 1 else letter.lower() for place, letter in enumerate("NZCVQ"))

    def __getattr__(self, name):
        return self.engine.get(Reg[name.upper()])

    def words(self, at, count):
        return list(struct.unpack_from(f"<{count}I", self.ram, at))

    def store(self, at, *words):
        struct.pack_into(f"<{len(words)}I", self.ram, at, *words)


def _count(halves):
    count, at = 0, 0
    while at < len(halves):
        at += 2 if halves[at] >> 11 >= 0b11101 else 1
        count += 1
    return count


@pytest.fixture(scope="module")
def core():
    return Core()


# --- sums and differences: instruction on R0 and R1, R0, R1, carry, R0 afterwards, NZCV afterwards

ADCS, SBCS, ADDS, SUBS, RSBS, CMP, CMN = 0x4148, 0x4188, 0x1840, 0x1A40, 0x4248, 0x4288, 0x42C8
SUMS = [
    (ADCS, 0, 0, 0, 0, "nZcv"),
    (ADCS, 0, 0, 1, 1, "nzcv"),
    (ADCS, ONES, 0, 1, 0, "nZCv"),
    (ADCS, ONES, ONES, 1, ONES, "NzCv"),
    (ADCS, ONES, ONES, 0, 0xFFFF_FFFE, "NzCv"),
    (ADCS, MAX, 0, 1, MIN, "NzcV"),
    (ADCS, MAX, MAX, 1, ONES, "NzcV"),
    (ADCS, MAX, ONES, 1, MAX, "nzCv"),
    (ADCS, MAX, MIN, 0, ONES, "Nzcv"),
    (ADCS, MAX, MIN, 1, 0, "nZCv"),
    (ADCS, MIN, ONES, 0, MAX, "nzCV"),
    (ADCS, MIN, ONES, 1, MIN, "NzCv"),
    (ADCS, MIN, MIN, 0, 0, "nZCV"),
    (ADCS, MIN, MIN, 1, 1, "nzCV"),
    (SBCS, 0, 0, 0, ONES, "Nzcv"),
    (SBCS, 0, 0, 1, 0, "nZCv"),
    (SBCS, 5, 4, 0, 0, "nZCv"),
    (SBCS, 5, 5, 0, ONES, "Nzcv"),
    (SBCS, 0, ONES, 0, 0, "nZcv"),
    (SBCS, 0, ONES, 1, 1, "nzcv"),
    (SBCS, MIN, 0, 0, MAX, "nzCV"),
    (SBCS, MIN, 1, 1, MAX, "nzCV"),
    (SBCS, MAX, ONES, 1, MIN, "NzcV"),
    (SBCS, MAX, ONES, 0, MAX, "nzcv"),
    (SBCS, 0, MIN, 1, MIN, "NzcV"),
    (SBCS, 0, MIN, 0, MAX, "nzcv"),
    (ADDS, ONES, 1, 1, 0, "nZCv"),
    (ADDS, MAX, 1, 1, MIN, "NzcV"),
    (ADDS, MIN, MIN, 0, 0, "nZCV"),
    (ADDS, MIN, MAX, 1, ONES, "Nzcv"),
    (SUBS, 1, 1, 0, 0, "nZCv"),
    (SUBS, 0, 1, 1, ONES, "Nzcv"),
    (SUBS, MIN, 1, 0, MAX, "nzCV"),
    (SUBS, MAX, ONES, 0, MIN, "NzcV"),
    (RSBS, 7, 0, 0, 0, "nZCv"),
    (RSBS, 7, 1, 1, ONES, "Nzcv"),
    (RSBS, 7, ONES, 1, 1, "nzcv"),
    (RSBS, 7, MIN, 0, MIN, "NzcV"),
    (CMP, 0, 0, 0, 0, "nZCv"),
    (CMP, 0, 1, 1, 0, "Nzcv"),
    (CMP, MIN, 1, 0, MIN, "nzCV"),
    (CMP, MAX, ONES, 1, MAX, "NzcV"),
    (CMP, ONES, MAX, 0, ONES, "NzCv"),
    (CMP, 0, MIN, 1, 0, "NzcV"),
    (CMP, MIN, MIN, 0, MIN, "nZCv"),
    (CMN, 0, 0, 1, 0, "nZcv"),
    (CMN, ONES, 1, 0, ONES, "nZCv"),
    (CMN, MAX, 1, 1, MAX, "NzcV"),
    (CMN, MIN, MIN, 0, MIN, "nZCV"),
    (CMN, MIN, ONES, 0, MIN, "nzCV"),
]


def test_sums(core):
    for half, r0, r1, carry, result, flags in SUMS:
        core.execute(half, r0=r0, r1=r1, flags="nzCvq" if carry else "nzcvq")
        assert (core.r0, core.flags) == (result, flags + "q"), f"{half:04x} of {r0:#x}, {r1:#x}, carry {carry}"


# RSBS.W r0, r1, #255
@each(
    ("r1", "result", "flags"), [(255, 0, "nZCvq"), (256, ONES, "Nzcvq"), (MIN, 0x8000_00FF, "NzcVq"), (0, 255, "nzCvq")]
)
def test_reverse_subtraction(core, r1, result, flags):
    core.execute(0xF1D1, 0x00FF, r1=r1)
    assert (core.r0, core.flags) == (result, flags)


# --- shifts by a register: by R1, R0, carry, R0 afterwards, NZC afterwards

LSLS, LSRS, ASRS, RORS = 0x4088, 0x40C8, 0x4108, 0x41C8
SHIFTS = [
    (LSLS, 0, 0x8000_0001, 1, 0x8000_0001, "NzC"),
    (LSLS, 0, 0x8000_0001, 0, 0x8000_0001, "Nzc"),
    (LSLS, 1, 0x8000_0001, 0, 2, "nzC"),
    (LSLS, 31, 3, 0, MIN, "NzC"),
    (LSLS, 32, 1, 0, 0, "nZC"),
    (LSLS, 32, 0xFFFF_FFFE, 1, 0, "nZc"),
    (LSLS, 33, ONES, 1, 0, "nZc"),
    (LSLS, 255, ONES, 1, 0, "nZc"),
    (LSLS, 0x100, 5, 1, 5, "nzC"),
    (LSLS, 0xFFFF_FF01, 1, 1, 2, "nzc"),
    (LSRS, 0, MIN, 1, MIN, "NzC"),
    (LSRS, 1, 1, 0, 0, "nZC"),
    (LSRS, 31, 0xC000_0000, 0, 1, "nzC"),
    (LSRS, 32, MIN, 0, 0, "nZC"),
    (LSRS, 32, MAX, 1, 0, "nZc"),
    (LSRS, 33, ONES, 1, 0, "nZc"),
    (LSRS, 0x300, 6, 0, 6, "nzc"),
    (ASRS, 0, MIN, 0, MIN, "Nzc"),
    (ASRS, 31, MIN, 1, ONES, "Nzc"),
    (ASRS, 31, 0xC000_0000, 0, ONES, "NzC"),
    (ASRS, 32, MIN, 0, ONES, "NzC"),
    (ASRS, 32, MAX, 1, 0, "nZc"),
    (ASRS, 33, MIN, 0, ONES, "NzC"),
    (ASRS, 255, MAX, 1, 0, "nZc"),
    (RORS, 0, 1, 1, 1, "nzC"),
    (RORS, 1, 1, 0, MIN, "NzC"),
    (RORS, 4, 0x1234_5678, 0, 0x8123_4567, "NzC"),
    (RORS, 32, 0x8000_0001, 0, 0x8000_0001, "NzC"),
    (RORS, 32, 1, 1, 1, "nzc"),
    (RORS, 33, 1, 0, MIN, "NzC"),
    (RORS, 0x100, 1, 1, 1, "nzC"),
    (RORS, 64, 0, 1, 0, "nZc"),
]


@each("wide", [False, True])
def test_shifts_by_register(core, wide):
    for half, amount, value, carry, result, flags in SHIFTS:
        kind = {LSLS: 0, LSRS: 1, ASRS: 2, RORS: 3}[half]
        halves = (0xFA10 | kind << 5, 0xF001) if wide else (half,)
        core.execute(*halves, r0=value, r1=amount, flags="nzCVq" if carry else "nzcVq")
        assert (core.r0, core.flags) == (result, flags + "Vq"), f"{half:04x} of {value:#x} by {amount}, carry {carry}"


# --- one operand, or two, to R0: code, R1, R2, flags before, R0 afterwards, flags afterwards

OPERATIONS = {
    "lsrs r0, r1, #32": ([0x0808], MIN, 0, "nzcVq", 0, "nZCVq"),
    "lsrs r0, r1, #32, no carry": ([0x0808], MAX, 0, "nzCVq", 0, "nZcVq"),
    "asrs r0, r1, #32": ([0x1008], MIN, 0, "nzcvq", ONES, "NzCvq"),
    "asrs r0, r1, #32, positive": ([0x1008], 0x4000_0000, 0, "nzCvq", 0, "nZcvq"),
    "movs r0, r1": ([0x0008], MIN, 0, "nZCVq", MIN, "NzCVq"),
    "movs.w r0, r1, rrx, carry in": ([0xEA5F, 0x0031], 2, 0, "nzCvq", 0x8000_0001, "Nzcvq"),
    "movs.w r0, r1, rrx, carry out": ([0xEA5F, 0x0031], 1, 0, "nzcvq", 0, "nZCvq"),
    "mov.w r0, r1, rrx": ([0xEA4F, 0x0031], 1, 0, "nzCvq", MIN, "nzCvq"),
    "movs.w r0, r1, ror #1": ([0xEA5F, 0x0071], 1, 0, "nzcvq", MIN, "NzCvq"),
    "movs.w r0, r1": ([0xEA5F, 0x0001], 0, 0, "NzCVq", 0, "nZCVq"),
    "movs.w r0, #0x80000000": ([0xF05F, 0x4000], 0, 0, "nzcVq", MIN, "NzCVq"),
    "movs.w r0, #0x40000000": ([0xF05F, 0x4080], 0, 0, "nzCvq", 0x4000_0000, "nzcvq"),
    "movs.w r0, #0x00ff00ff, carry stays": ([0xF05F, 0x10FF], 0, 0, "nzCvq", 0x00FF_00FF, "nzCvq"),
    "mvns.w r0, #0xff00ff00": ([0xF07F, 0x20FF], 0, 0, "nzcvq", 0x00FF_00FF, "nzcvq"),
    "mov.w r0, #0xabababab": ([0xF04F, 0x30AB], 0, 0, "nzcvq", 0xABAB_ABAB, "nzcvq"),
    "tst.w r1, #0x80000000": ([0xF011, 0x4F00], 0, 0, "NzcVq", 0, "nZCVq"),
    "teq.w r1, #255": ([0xF091, 0x0FFF], 255, 0, "NzCVq", 0, "nZCVq"),
    "ands.w r0, r1, r2, lsl #1": ([0xEA11, 0x0042], ONES, 0x8000_0001, "nzcvq", 2, "nzCvq"),
    "bics.w r0, r1, r2": ([0xEA31, 0x0002], 0xFF, 0x0F, "nzCvq", 0xF0, "nzCvq"),
    "orn r0, r1, r2": ([0xEA61, 0x0002], 0x30, 0xFFFF_FFF0, "nzcvq", 0x3F, "nzcvq"),
    "mvns r0, r1": ([0x43C8], 0, 0, "nZCVq", ONES, "NzCVq"),
    "muls r0, r1, r0, flags but N and Z stay": ([0x0010, 0x4348], 0x1_0000, 0x1_0000, "NzCVq", 0, "nZCVq"),
    "sdiv 7 / 2": ([0xFB91, 0xF0F2], 7, 2, "NZCVQ", 3, "NZCVQ"),
    "sdiv -7 / 2": ([0xFB91, 0xF0F2], -7 & ONES, 2, "nzcvq", -3 & ONES, "nzcvq"),
    "sdiv 7 / -2": ([0xFB91, 0xF0F2], 7, -2 & ONES, "nzcvq", -3 & ONES, "nzcvq"),
    "sdiv -7 / -2": ([0xFB91, 0xF0F2], -7 & ONES, -2 & ONES, "nzcvq", 3, "nzcvq"),
    "sdiv by zero": ([0xFB91, 0xF0F2], -7 & ONES, 0, "nzcvq", 0, "nzcvq"),
    "sdiv least / -1": ([0xFB91, 0xF0F2], MIN, ONES, "nzcvq", MIN, "nzcvq"),
    "sdiv least / least": ([0xFB91, 0xF0F2], MIN, MIN, "nzcvq", 1, "nzcvq"),
    "udiv greatest / 2": ([0xFBB1, 0xF0F2], ONES, 2, "nzcvq", MAX, "nzcvq"),
    "udiv by zero": ([0xFBB1, 0xF0F2], ONES, 0, "nzcvq", 0, "nzcvq"),
    "udiv less / greater": ([0xFBB1, 0xF0F2], MIN, ONES, "nzcvq", 0, "nzcvq"),
    "ubfx r0, r1, #4, #8": ([0xF3C1, 0x1007], 0x1234_5678, 0, "NzCvq", 0x67, "NzCvq"),
    "ubfx r0, r1, #31, #1": ([0xF3C1, 0x70C0], MIN, 0, "nzcvq", 1, "nzcvq"),
    "ubfx r0, r1, #0, #32": ([0xF3C1, 0x001F], 0x8765_4321, 0, "nzcvq", 0x8765_4321, "nzcvq"),
    "sbfx r0, r1, #4, #8": ([0xF341, 0x1007], 0x0000_0800, 0, "nzcvq", 0xFFFF_FF80, "nzcvq"),
    "sbfx r0, r1, #31, #1": ([0xF341, 0x70C0], MIN, 0, "nzcvq", ONES, "nzcvq"),
    "clz of 0": ([0xFAB1, 0xF081], 0, 0, "nzcvq", 32, "nzcvq"),
    "clz of 1": ([0xFAB1, 0xF081], 1, 0, "nzcvq", 31, "nzcvq"),
    "clz of 0x8000": ([0xFAB1, 0xF081], 0x8000, 0, "nzcvq", 16, "nzcvq"),
    "clz of all": ([0xFAB1, 0xF081], ONES, 0, "nzcvq", 0, "nzcvq"),
    "rbit": ([0xFA91, 0xF0A1], 0x1234_5678, 0, "nzcvq", 0x1E6A_2C48, "nzcvq"),
    "rev.w": ([0xFA91, 0xF081], 0x1234_5678, 0, "nzcvq", 0x7856_3412, "nzcvq"),
    "rev16.w": ([0xFA91, 0xF091], 0x1234_5678, 0, "nzcvq", 0x3412_7856, "nzcvq"),
    "revsh.w": ([0xFA91, 0xF0B1], 0x1234_0080, 0, "nzcvq", 0xFFFF_8000, "nzcvq"),
    "rev": ([0xBA08], 0x1234_5678, 0, "nzcvq", 0x7856_3412, "nzcvq"),
    "rev16": ([0xBA48], 0x1234_5678, 0, "nzcvq", 0x3412_7856, "nzcvq"),
    "revsh": ([0xBAC8], 0x1234_FF7F, 0, "nzcvq", 0x0000_7FFF, "nzcvq"),
    "sxtb": ([0xB248], 0x80, 0, "nzcvq", 0xFFFF_FF80, "nzcvq"),
    "sxth": ([0xB208], 0x1_7FFF, 0, "nzcvq", 0x7FFF, "nzcvq"),
    "uxtb": ([0xB2C8], 0x180, 0, "nzcvq", 0x80, "nzcvq"),
    "uxth": ([0xB288], ONES, 0, "nzcvq", 0xFFFF, "nzcvq"),
    "sxtb.w r0, r1, ror #8": ([0xFA4F, 0xF091], 0x8000, 0, "nzcvq", 0xFFFF_FF80, "nzcvq"),
    "uxth.w r0, r1, ror #24": ([0xFA1F, 0xF0B1], 0x1234_5678, 0, "nzcvq", 0x7812, "nzcvq"),
    "mul.w": ([0xFB01, 0xF002], ONES, 3, "nzcvq", 0xFFFF_FFFD, "nzcvq"),
    "movw r0, #0xffff": ([0xF64F, 0x70FF], 0, 0, "nzcvq", 0xFFFF, "nzcvq"),
    "mrs r0, apsr": ([0xF3EF, 0x8000], 0, 0, "NzCvQ", 0xA800_0000, "NzCvQ"),
    "mrs r0, xpsr, the rest reads as zero": ([0xF3EF, 0x8003], 0, 0, "nZcVq", 0x5000_0000, "nZcVq"),
    "msr apsr_nzcvq, r1": ([0xF381, 0x8800], ONES, 0, "nzcvq", 0, "NZCVQ"),
    "msr clears Q": ([0xF381, 0x8800], MAX & ~(1 << 27), 0, "NzcvQ", 0, "nZCVq"),
    "adds r0, #1 within it eq sets no flags": ([0xBF08, 0x3001], 0, 0, "nZcvq", 1, "nZcvq"),
    "cmp r1, #1 within it eq sets flags": ([0xBF08, 0x2901], 0, 0, "nZcvq", 0, "Nzcvq"),
    "adds.w r0, #1 within it eq sets flags": ([0xBF08, 0xF110, 0x0001], 0, 0, "nZcvq", 1, "nzcvq"),
    "cbnz does not change flags": ([0xB901, NOP, 0x2001], 1, 0, "nZCVq", 1, "nzCVq"),
}


def test_operations(core):
    for name, (halves, r1, r2, before, result, flags) in OPERATIONS.items():
        core.execute(*halves, r1=r1, r2=r2, flags=before)
        assert (core.r0, core.flags) == (result, flags), name


# --- saturation: code, R1, R0 afterwards, whether Q is set

SSAT_1, SSAT_8, SSAT_32 = (0xF301, 0x0000), (0xF301, 0x0007), (0xF301, 0x001F)
USAT_0, USAT_8, USAT_31 = (0xF381, 0x0000), (0xF381, 0x0008), (0xF381, 0x001F)
SSAT_16_LSL_4, SSAT_8_ASR_31, USAT_4_ASR_4 = (0xF301, 0x100F), (0xF321, 0x70C7), (0xF3A1, 0x1004)
SATURATIONS = [
    (SSAT_1, 0, 0, False),
    (SSAT_1, 1, 0, True),
    (SSAT_1, ONES, ONES, False),
    (SSAT_1, -2 & ONES, ONES, True),
    (SSAT_8, 127, 127, False),
    (SSAT_8, 128, 127, True),
    (SSAT_8, MAX, 127, True),
    (SSAT_8, -128 & ONES, 0xFFFF_FF80, False),
    (SSAT_8, -129 & ONES, 0xFFFF_FF80, True),
    (SSAT_8, MIN, 0xFFFF_FF80, True),
    (SSAT_32, MIN, MIN, False),
    (SSAT_32, MAX, MAX, False),
    (USAT_0, 0, 0, False),
    (USAT_0, 1, 0, True),
    (USAT_0, ONES, 0, True),
    (USAT_8, 255, 255, False),
    (USAT_8, 256, 255, True),
    (USAT_8, ONES, 0, True),
    (USAT_31, MAX, MAX, False),
    (USAT_31, MIN, 0, True),
    (SSAT_16_LSL_4, 0x7FF, 0x7FF0, False),
    (SSAT_16_LSL_4, 0x1000, 0x7FFF, True),
    (SSAT_16_LSL_4, 0x1000_0000, 0, False),  # what is shifted out does not count
    (SSAT_16_LSL_4, 0x0800_0000, 0xFFFF_8000, True),
    (SSAT_8_ASR_31, MIN, ONES, False),
    (USAT_4_ASR_4, 0xFF, 15, False),
    (USAT_4_ASR_4, 0x100, 15, True),
    (USAT_4_ASR_4, MIN, 0, True),
]


@each(("halves", "value", "result", "saturated"), SATURATIONS)
def test_saturation(core, halves, value, result, saturated):
    core.execute(*halves, r1=value, flags="NzCvq")
    assert (core.r0, core.flags) == (result, "NzCvQ" if saturated else "NzCvq")
    core.execute(*halves, r1=value, flags="nZcVQ")
    assert (core.r0, core.flags) == (result, "nZcVQ")  # Q is only ever set


# --- multiplication with more operands: code, R0-R3, R0 and R1 afterwards

UMULL, SMULL, UMLAL, SMLAL = (0xFBA2, 0x0103), (0xFB82, 0x0103), (0xFBE2, 0x0103), (0xFBC2, 0x0103)
MLA, MLS = (0xFB01, 0x3002), (0xFB01, 0x3012)  # r0, r1, r2, r3
PRODUCTS = [
    (UMULL, (7, 7, ONES, ONES), (1, 0xFFFF_FFFE)),
    (UMULL, (7, 7, MIN, 2), (0, 1)),
    (UMULL, (7, 7, 0, ONES), (0, 0)),
    (SMULL, (7, 7, ONES, ONES), (1, 0)),
    (SMULL, (7, 7, MIN, MIN), (0, 0x4000_0000)),
    (SMULL, (7, 7, MIN, 1), (MIN, ONES)),
    (SMULL, (7, 7, MAX, MIN), (MIN, 0xC000_0000)),
    (UMLAL, (ONES, ONES, ONES, ONES), (0, 0xFFFF_FFFE)),
    (UMLAL, (ONES, 0, 1, 1), (0, 1)),
    (UMLAL, (ONES, ONES, 1, 1), (0, 0)),
    (SMLAL, (0, 0, ONES, 1), (ONES, ONES)),
    (SMLAL, (ONES, 0, 1, 1), (0, 1)),
    (SMLAL, (ONES, MAX, 1, 1), (0, MIN)),
    (SMLAL, (1, 0, ONES, 1), (0, 0)),
    (SMLAL, (0, MIN, ONES, 1), (ONES, MAX)),
    (MLA, (7, 3, 4, 5), (17, 3)),
    (MLA, (7, ONES, ONES, ONES), (0, ONES)),
    (MLS, (7, 3, 4, 5), (-7 & ONES, 3)),
    (MLS, (7, 3, 4, 12), (0, 3)),
]


@each(("halves", "before", "after"), PRODUCTS)
def test_products(core, halves, before, after):
    r0, r1, r2, r3 = before
    core.execute(*halves, r0=r0, r1=r1, r2=r2, r3=r3, flags="NzCvQ")
    assert (core.r0, core.r1, core.flags) == (*after, "NzCvQ")


# --- bit fields: code, R0, R1, R0 afterwards

FIELDS = [
    ((0xF361, 0x200F), ONES, 0x1234_5678, 0xFFFF_78FF),  # bfi r0, r1, #8, #8
    ((0xF361, 0x200F), 0, ONES, 0x0000_FF00),
    ((0xF361, 0x001F), 0x1111_1111, 0x8765_4321, 0x8765_4321),  # bfi r0, r1, #0, #32
    ((0xF361, 0x70DF), 0, 1, MIN),  # bfi r0, r1, #31, #1
    ((0xF361, 0x70DF), ONES, 0xFFFF_FFFE, MAX),
    ((0xF36F, 0x101B), ONES, 0, 0xF000_000F),  # bfc r0, #4, #24
    ((0xF36F, 0x001F), ONES, 0, 0),  # bfc r0, #0, #32
    ((0xF2C1, 0x2034), 0xFFFF_ABCD, 0, 0x1234_ABCD),  # movt r0, #0x1234
]


@each(("halves", "r0", "r1", "result"), FIELDS)
def test_fields(core, halves, r0, r1, result):
    core.execute(*halves, r0=r0, r1=r1)
    assert core.r0 == result


# --- conditions (DDI0403 table A7-1)

CONDITIONS = {
    0: lambda n, z, c, v: z,
    1: lambda n, z, c, v: not z,
    2: lambda n, z, c, v: c,
    3: lambda n, z, c, v: not c,
    4: lambda n, z, c, v: n,
    5: lambda n, z, c, v: not n,
    6: lambda n, z, c, v: v,
    7: lambda n, z, c, v: not v,
    8: lambda n, z, c, v: c and not z,
    9: lambda n, z, c, v: not c or z,
    10: lambda n, z, c, v: n == v,
    11: lambda n, z, c, v: n != v,
    12: lambda n, z, c, v: not z and n == v,
    13: lambda n, z, c, v: z or n != v,
    14: lambda n, z, c, v: True,
}
ALL_FLAGS = [tuple(bool(bits >> place & 1) for place in (3, 2, 1, 0)) for bits in range(16)]


def written(flags):
    return "".join(letter if flag else letter.lower() for letter, flag in zip("NZCV", flags, strict=True)) + "q"


@each("condition", CONDITIONS)
def test_conditions_of_it(core, condition):
    for flags in ALL_FLAGS:
        core.execute(0xBF08 | condition << 4, 0x2001, NOP, flags=written(flags), instructions=2)
        assert core.r0 == bool(CONDITIONS[condition](*flags)), flags


@each("condition", list(CONDITIONS)[:-1])
def test_conditions_of_branches(core, condition):
    narrow, wide = (0xD002 | condition << 8,), (0xF000 | condition << 6, 0x8002)  # to 8 bytes from here
    for flags in ALL_FLAGS:
        for branch in (narrow, wide):
            core.execute(*branch, flags=written(flags), instructions=1)
            assert core.pc == CODE + (8 if CONDITIONS[condition](*flags) else 2 * len(branch)), flags


# for a condition with an even number; T executes if it holds, E if it does not
MASKS = {0x8: "T", 0x4: "TT", 0xC: "TE", 0x2: "TTT", 0x6: "TTE", 0xA: "TET", 0xE: "TEE"}
MASKS |= {0x1: "TTTT", 0x3: "TTTE", 0x5: "TTET", 0x7: "TTEE", 0x9: "TETT", 0xB: "TETE", 0xD: "TEET", 0xF: "TEEE"}


@pytest.mark.parametrize("holds", [True, False])
@pytest.mark.parametrize(("mask", "letters"), MASKS.items(), ids=MASKS.values())
def test_masks_of_it(core, mask, letters, holds):
    """MOVS r0-r3, #1 in the block, MOVS r4, #1 after it; a block counts as its IT and what is executed."""
    moves = [0x2001 | place << 8 for place in range(len(letters))]
    executed = [(letter == "T") is holds for letter in letters]
    core.execute(0xBF00 | mask, *moves, 0x2401, flags="nZcvq" if holds else "nzcvq", instructions=2 + sum(executed))
    assert [core.r0, core.r1, core.r2, core.r3][: len(letters)] == executed
    assert core.r4 == 1


@each("holds", [True, False])
def test_a_mask_with_an_odd_condition_is_the_other_way_round(core, holds):
    """ITETE NE is BF15 where ITETE EQ is BF0B."""
    core.execute(0xBF15, 0x2001, 0x2101, 0x2201, 0x2301, flags="nzcvq" if holds else "nZcvq", instructions=3)
    assert [core.r0, core.r1, core.r2, core.r3] == [holds, not holds, holds, not holds]


# --- PC, memory, stack


@each(
    ("halves", "expected"),
    [
        ([0xA000], CODE + 4),  # adr r0, .+4: PC rounded down to a word
        ([NOP, 0xA000], CODE + 4),
        ([0x4678], CODE + 4),  # mov r0, pc: not rounded
        ([NOP, 0x4678], CODE + 6),
        ([NOP, 0x4478], CODE + 6),  # add r0, pc
        ([NOP, 0xF20F, 0x0003], CODE + 7),  # addw r0, pc, #3
        ([NOP, 0xF2AF, 0x0003], CODE + 1),  # subw r0, pc, #3
    ],
)
def test_what_pc_reads_as(core, halves, expected):
    core.execute(*halves)
    assert core.r0 == expected


@each(
    ("halves", "registers", "expected"),
    [
        ([0x6808], {}, {"r0": 0x8382_8180}),  # ldr r0, [r1]
        ([0xF8D1, 0x0001], {}, {"r0": 0x8483_8281}),  # ldr.w r0, [r1, #1]
        ([0x7808], {}, {"r0": 0x80}),  # ldrb
        ([0x5688], {}, {"r0": 0xFFFF_FF80}),  # ldrsb r0, [r1, r2]
        ([0x8808], {}, {"r0": 0x8180}),  # ldrh
        ([0xF9B1, 0x0001], {}, {"r0": 0xFFFF_8281}),  # ldrsh.w r0, [r1, #1]
        ([0xF851, 0x0F04], {}, {"r0": 0x8786_8584, "r1": RAM + 0x44}),  # ldr r0, [r1, #4]!
        ([0xF851, 0x0904], {}, {"r0": 0x8382_8180, "r1": RAM + 0x3C}),  # ldr r0, [r1], #-4
        ([0xF851, 0x0032], {"r2": 1}, {"r0": 0x8B8A_8988}),  # ldr.w r0, [r1, r2, lsl #3]
        ([0xE9D1, 0x0301], {}, {"r0": 0x8786_8584, "r3": 0x8B8A_8988}),  # ldrd r0, r3, [r1, #4]
        ([0xE8F1, 0x0302], {}, {"r0": 0x8382_8180, "r3": 0x8786_8584, "r1": RAM + 0x48}),  # ldrd r0, r3, [r1], #8
        ([0xC90D], {}, {"r0": 0x8382_8180, "r2": 0x8786_8584, "r3": 0x8B8A_8988, "r1": RAM + 0x4C}),  # ldm r1!
        ([0xC903], {}, {"r0": 0x8382_8180, "r1": 0x8786_8584}),  # ldm r1, {r0, r1}: the base is loaded
        ([0xE931, 0x0005], {"r1": RAM + 0x48}, {"r0": 0x8382_8180, "r2": 0x8786_8584, "r1": RAM + 0x40}),  # ldmdb r1!
        ([0xBC03], {"sp": RAM + 0x40}, {"r0": 0x8382_8180, "r1": 0x8786_8584, "sp": RAM + 0x48}),  # pop {r0, r1}
    ],
)
def test_loads(core, halves, registers, expected):
    core.ram[0x40:0x60] = bytes(range(0x80, 0xA0))
    core.execute(*halves, **({"r1": RAM + 0x40} | registers))
    assert {name: getattr(core, name) for name in expected} == expected


@each(
    ("halves", "first", "expected", "base"),
    [
        ([0x6008], 0x100, [0xA0A1_A2A3], 0x100),  # str r0, [r1]
        ([0x7008], 0x100, [0xEEEE_EEA3], 0x100),  # strb
        ([0x8008], 0x100, [0xEEEE_A2A3], 0x100),  # strh
        ([0xF8C1, 0x0001], 0x100, [0xA1A2_A3EE, 0xEEEE_EEA0], 0x100),  # str.w r0, [r1, #1]
        ([0xF841, 0x0D04], 0x0FC, [0xA0A1_A2A3], 0x0FC),  # str r0, [r1, #-4]!
        ([0xE9E1, 0x0302], 0x108, [0xA0A1_A2A3, 0x3333_3333], 0x108),  # strd r0, r3, [r1, #8]!
        ([0xC109], 0x100, [0xA0A1_A2A3, 0x3333_3333], 0x108),  # stm r1!, {r0, r3}
        ([0xC10A], 0x100, [RAM + 0x100, 0x3333_3333], 0x108),  # stm r1!, {r1, r3}: the base as it was
        ([0xE921, 0x0009], 0x0F8, [0xA0A1_A2A3, 0x3333_3333], 0x0F8),  # stmdb r1!, {r0, r3}
    ],
)
def test_stores(core, halves, first, expected, base):
    core.store(0xF0, *[0xEEEE_EEEE] * 16)
    core.execute(*halves, r0=0xA0A1_A2A3, r1=RAM + 0x100, r3=0x3333_3333)
    assert core.words(first, len(expected)) == expected
    assert core.r1 == RAM + base


def test_push_stores_the_lowest_register_lowest(core):
    core.execute(0xB505, r0=10, r2=12, lr=14, sp=RAM + 0x80)  # push {r0, r2, lr}
    assert core.words(0x74, 3) == [10, 12, 14]
    assert core.sp == RAM + 0x74


@each(
    ("halves", "index", "target"),
    [
        ([0xE8DF, 0xF001, 0x0402], 0, 4 + 2 * 2),  # tbb [pc, r1]
        ([0xE8DF, 0xF001, 0x0402], 1, 4 + 2 * 4),
        ([0xE8DF, 0xF011, 0x0003, 0x0005], 1, 4 + 2 * 5),  # tbh [pc, r1, lsl #1]
    ],
)
def test_table_branches(core, halves, index, target):
    core.execute(*halves, r1=index, instructions=1)
    assert core.pc == CODE + target


@each(
    ("halves", "r0", "taken"), [([0xB108], 0, True), ([0xB108], 1, False), ([0xB908], 0, False), ([0xB908], MIN, True)]
)
def test_compare_and_branch(core, halves, r0, taken):
    core.execute(*halves, r0=r0, flags="NZCVQ", instructions=1)
    assert core.pc == CODE + (6 if taken else 2)
    assert core.flags == "NZCVQ"


@each(
    ("halves", "status", "word"),
    [
        ([0xE841, 0x2000], 1, 0xEEEE_EEEE),  # strex without ldrex stores nothing
        ([0xE851, 0x3F00, 0xE841, 0x2000], 0, 0x22),  # ldrex r3, [r1]; strex r0, r2, [r1]
        ([0xE851, 0x3F00, 0xF3BF, 0x8F2F, 0xE841, 0x2000], 1, 0xEEEE_EEEE),  # clrex between them
        ([0xE851, 0x3F00, 0xE841, 0x2000, 0xE841, 0x2000], 1, 0x22),  # a second time
    ],
)
def test_exclusive_stores(core, halves, status, word):
    core.store(0x100, 0xEEEE_EEEE)
    core.execute(0xF3BF, 0x8F2F, *halves, r1=RAM + 0x100, r2=0x22)
    assert core.r0 == status
    assert core.words(0x100, 1) == [word]


@each("place", [0, 1, 2, 3])
@each("flags", ["nZcvq", "nzcvq"])
@each("mask", [0b1001, 0b0101, 0b1111, 0b0001])
def test_isb_within_an_it_block(core, place, flags, mask):
    """It is executed or not, and the block goes on: after one, two or three of adds r0; adds r1; adds r2, #1."""
    sums = [0x3001, 0x3101, 0x3201]
    sides = [0, *(mask >> bit & 1 for bit in (3, 2, 1))]
    del sides[place]
    core.execute(0xBF00 | mask, *sums[:place], 0xF3BF, 0x8F6F, *sums[place:], flags=flags, instructions=9)
    assert [core.r0, core.r1, core.r2] == [int((side == 0) == ("Z" in flags)) for side in sides]


def test_isb_that_is_no_longer_in_an_it_block(core):
    core.execute(0xBF0A, 0xF3BF, 0x8F6F, 0x3001, 0x3101, flags="nZcvq", instructions=9)  # itet eq
    assert [core.r0, core.r1] == [0, 1]
    core.execute(NOP, 0xF3BF, 0x8F6F, 0x3001, 0x3101, flags="nzcvq", instructions=5)
    assert [core.r0, core.r1] == [1, 1]
    # itt eq; adds r0, #1; adds r1, #1; cmp r0, #5; b to the next; adds r2, #1
    core.execute(0xBF04, 0x3001, 0x3101, 0x2805, 0xE7FF, 0x3201, flags="nZcvq", instructions=7)
    assert [core.r0, core.r1, core.r2] == [1, 1, 1]


# --- special registers


@each("number", [8, 9])  # MSP, PSP
def test_msr_writes_no_low_bits_of_a_stack_pointer(core, number):
    core.execute(0xF381, 0x8800 | number, 0xF3EF, 0x8000 | number, r1=RAM + 0x83)  # msr, mrs r0
    assert core.r0 == RAM + 0x80


@each(
    ("number", "before", "written", "after"),
    [
        (17, 0, 0x4F, 0x40),  # BASEPRI
        (17, 0, 0x1234_56FF, 0xF0),
        (17, 0x40, 0x0F, 0),
        (18, 0x40, 0x3F, 0x30),  # BASEPRI_MAX
        (18, 0x40, 0x4F, 0x40),
        (18, 0x40, 0x5F, 0x40),
        (18, 0, 0xFF, 0xF0),
        (18, 0x40, 0, 0x40),
    ],
)
def test_base_priority_has_four_bits(core, number, before, written, after):
    """Those of the lower priorities are not implemented: they read as zero and are not written (section B1.4.3)."""
    core.engine.set(Reg.BASEPRI, before)
    core.execute(0xF381, 0x8800 | number, 0xF3EF, 0x8011, r1=written)  # msr, mrs r0, basepri
    assert core.r0 == core.basepri == after
    core.engine.set(Reg.BASEPRI, 0)
