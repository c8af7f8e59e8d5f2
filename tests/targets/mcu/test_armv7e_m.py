"""Instructions that a Cortex-M3 lacks, as an assembler encodes them (GNU as, -mcpu=cortex-m7 and cortex-m3)."""

from __future__ import annotations

import struct

from targets.mcu.armv7e_m import first_beyond_armv7_m

EXTENSION = """
eac2 0103 pkhbt|eac2 1123 pkhtb|f322 0104 ssat16|f3a2 0105 usat16|fa02 f183 sxtah|fa12 f183 uxtah|fa42 f183 sxtab
fa52 f183 uxtab|fa2f f183 sxtb16|fa3f f183 uxtb16|fa22 f183 sxtab16|fa32 f183 uxtab16|fa92 f103 sadd16
fac2 f153 uqsub8|faa2 f163 uhasx|fa83 f182 qadd|fa83 f1b2 qdsub|faa2 f183 sel|fb12 4103 smlabb|fb12 f103 smulbb
fb22 4103 smlad|fb32 4103 smlawb|fb42 4103 smlsd|fb52 4103 smmla|fb62 4103 smmls|fb52 f103 smmul|fb72 f103 usad8
fb72 4103 usada8|fbc3 1284 smlalbb|fbc3 12c4 smlald|fbd3 12c4 smlsld|fbe3 1264 umaal|ee30 0a81 vadd.f32
ed91 0a00 vldr|ed2d 8a02 vpush|eef1 1a10 vmrs|fe80 0a81 vmaxnm.f32
"""
BASE = """
f302 0104 ssat|f322 1104 ssat, asr|f382 0145 usat|fa0f f183 sxth|fa1f f983 uxth|fa4f f183 sxtb|fa5f f983 uxtb
fa02 f103 lsl|fa62 f103 ror|fa93 f983 rev|fa93 f1a3 rbit|fa93 f9b3 revsh|fa93 f993 rev16|fab3 f183 clz|fb02 4103 mla
fb02 4113 mls|fb02 f103 mul|fb83 1204 smull|fba3 1204 umull|fbc3 1204 smlal|fbe3 1204 umlal|fb92 f1f3 sdiv
fbb2 f1f3 udiv|f7ff fffe bl|e9d3 1200 ldrd|e8df f001 tbb|ea42 0903 orr|f64f 3130 movw|f3ef 8109 mrs|ee01 1f72 mcr
e852 1f00 ldrex|f362 01c6 bfi|f342 01c3 sbfx|f7ff bffe b
"""


def rows(text: str) -> list[tuple[str, bytes]]:
    found = [row.split(maxsplit=2) for line in text.split("\n") for row in line.split("|") if row]
    return [(name, struct.pack("<HH", int(first, 16), int(second, 16))) for first, second, name in found]


def test_each_instruction_of_the_extension_is_found():
    assert [name for name, code in rows(EXTENSION) if first_beyond_armv7_m(code) != 0] == []
    assert len(rows(EXTENSION)) == 37


def test_none_of_armv7_m_is_taken_for_one():
    assert [name for name, code in rows(BASE) if first_beyond_armv7_m(code) is not None] == []


def test_the_second_half_of_an_instruction_is_not_the_first_of_another():
    move_nop_pkhbt = struct.pack("<5H", 0xF64F, 0xEAC2, 0xBF00, 0xEAC2, 0x0103)
    assert first_beyond_armv7_m(move_nop_pkhbt) == 6
    assert first_beyond_armv7_m(move_nop_pkhbt[:6]) is None
