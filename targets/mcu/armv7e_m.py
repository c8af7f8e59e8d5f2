"""Which instructions a Cortex-M4 or M7 has and a Cortex-M3 lacks (DDI0403 section A5.3, "DSP extension", and A6).

Linkers call a program ARMv7E-M as soon as one of its libraries is. Whether it needs such a core its code says.
"""

from __future__ import annotations

import struct

__all__ = ["first_beyond_armv7_m"]

# (mask, value) of both halfwords; what ARMv7-M has in the same place stands in `_BASE`.
_EXTENSION = (
    (0xFFF0_0000, 0xEAC0_0000),  # PKHBT, PKHTB
    (0xFFF0_F0C0, 0xF320_0000),  # SSAT16
    (0xFFF0_F0C0, 0xF3A0_0000),  # USAT16
    (0xFF80_F0C0, 0xFA00_F080),  # SXTAH, SXTAB16 and their like
    (0xFF80_F080, 0xFA80_F000),  # parallel addition and subtraction
    (0xFFF0_F0C0, 0xFA80_F080),  # QADD, QDADD, QSUB, QDSUB
    (0xFFF0_F0F0, 0xFAA0_F080),  # SEL
    (0xFF80_00C0, 0xFB00_0000),  # SMLAxy, SMLAD, SMLAW, SMLSD, SMMLA, SMMLS, USAD8
    (0xFFF0_00C0, 0xFBC0_0080),  # SMLALxy, and SMLALD below
    (0xFFF0_00E0, 0xFBC0_00C0),
    (0xFFF0_00E0, 0xFBD0_00C0),  # SMLSLD
    (0xFFF0_00F0, 0xFBE0_0060),  # UMAAL
    (0xEC00_0E00, 0xEC00_0A00),  # floating point: coprocessors 10 and 11
)
_BASE = (
    (0xFFEF_F0C0, 0xFA0F_F080),  # SXTH, UXTH
    (0xFFEF_F0C0, 0xFA4F_F080),  # SXTB, UXTB
    (0xFFF0_00C0, 0xFB00_0000),  # MLA, MUL, MLS
)
_WIDE = 0xE800
"""A halfword from this on begins an instruction of two (DDI0403 section A5.1)."""


def first_beyond_armv7_m(code: bytes) -> int | None:
    """Return the offset of the first instruction that ARMv7-M lacks, in code without data; None if there is none."""
    halves = struct.unpack(f"<{len(code) // 2}H", code[: len(code) & ~1])
    at = 0
    while at < len(halves):
        if halves[at] < _WIDE:
            at += 1
            continue
        word = halves[at] << 16 | (halves[at + 1] if at + 1 < len(halves) else 0)
        if _any(_EXTENSION, word) and not _any(_BASE, word):
            return 2 * at
        at += 2
    return None


def _any(patterns: tuple[tuple[int, int], ...], word: int) -> bool:
    return any(word & mask == value for mask, value in patterns)
