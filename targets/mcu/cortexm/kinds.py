"""The cores there are, as data: what tells a Cortex-M7 from a Cortex-M3 besides the chip around it.

Cortex-M3 r1p1: Technical Reference Manual (DDI0337), and the choices of ST in the STM32F103 (RM0008, PM0056).
Cortex-M7 r1p0 and r1p1 with single and double precision floating point: Technical Reference Manual (DDI0489), and the
choices of ST in the STM32F767 and STM32H753 (RM0410, RM0433, PM0253).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

__all__ = ["CORES", "CORTEX_M3", "CORTEX_M7", "CORTEX_M7_R1P1", "LOCKED", "CoreKind", "FpuKind"]

LOCKED = 0b11
"""LSR: there is a lock, and it is locked (DDI0403 section D1.1)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FpuKind:
    """The floating-point extension of a core (DDI0403 section B4.7).

    Attributes:
        mvfr: media and floating-point features 0 to 2.
    """

    mvfr: tuple[int, int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class CoreKind:
    """A core as a chip has it.

    Attributes:
        name: for people.
        model: how the engine calls it: ``M3`` or ``M7``.
        cpuid: identification (DDI0403 section B3.2.3).
        identity: the other identification registers, from PFR0 to ISAR4 (DDI0403 section B4.1).
        irq_count: interrupt inputs of the NVIC.
        priority_bits: implemented bits of a priority.
        vtor_bits: implemented bits of VTOR.
        ccr_reset: CCR after reset.
        ccr_writable: bits of CCR that can be written.
        actlr_writable: bits of ACTLR that can be written.
        systick_calibration: STK_CALIB.
        bit_band: there are regions in which a word stands for a bit.
        mpu_regions: of the memory protection unit; 0: there is none.
        fpu: the floating-point extension, or None.
        ccsidr: sizes of the caches, as CCSIDR tells them by what CSSELR selects: data, instructions; none: no caches.
        tcm: the tightly coupled memories' control registers after reset, ITCMCR and DTCMCR; none: no such memories.
        dwt_lock: what LSR of the DWT reads after power-on: `LOCKED`, or 0 where LAR locks nothing; None: there is none.
        component_ids: PID0 to PID3 of the debug blocks, by block (DDI0403 section C1.2.4).
        flat_cpi: cycles per instruction at 0, 1, ... flash wait states, for the timing model ``flat``.
    """

    name: str
    model: str
    cpuid: int
    identity: tuple[int, ...]
    irq_count: int
    priority_bits: int
    vtor_bits: int
    ccr_reset: int
    ccr_writable: int
    actlr_writable: int
    systick_calibration: int
    bit_band: bool
    mpu_regions: int
    fpu: FpuKind | None
    ccsidr: tuple[int, ...]
    tcm: tuple[int, ...]
    dwt_lock: int | None
    component_ids: Mapping[str, tuple[int, int, int, int]]
    flat_cpi: tuple[Fraction, ...]


CORTEX_M3 = CoreKind(
    name="Cortex-M3",
    model="M3",
    cpuid=0x411F_C231,
    # DDI0337, table of the identification registers
    identity=(
        *(0x0000_0030, 0x0000_0200, 0x0010_0000, 0),  # PFR0, PFR1, DFR0, AFR0
        *(0x0000_0030, 0, 0, 0),  # MMFR0 to MMFR3
        *(0x0114_1110, 0x0211_1000, 0x2111_2231, 0x0111_1110, 0x0131_0102),  # ISAR0 to ISAR4
    ),
    irq_count=43,  # RM0008 table 63
    priority_bits=4,
    vtor_bits=0x3FFF_FF80,
    ccr_reset=0,
    ccr_writable=0x31B,
    actlr_writable=0b111,
    # TENMS 9000: one millisecond at 72 MHz / 8 (RM0008 section 10.1.1); SKEW reads one, NOREF zero (PM0056 4.5.4)
    systick_calibration=1 << 30 | 9000,
    bit_band=True,
    mpu_regions=0,
    fpu=None,
    ccsidr=(),
    tcm=(),
    dwt_lock=None,
    component_ids={
        "SCS": (0x00, 0xB0, 0x1B, 0x00),
        "DWT": (0x02, 0xB0, 0x1B, 0x00),
        "FPB": (0x03, 0xB0, 0x0B, 0x00),
        "ITM": (0x01, 0xB0, 0x1B, 0x00),
        "TPIU": (0x23, 0xB9, 0x1B, 0x00),
    },
    # A choice: compiled code for this core, run from flash, takes 1.2 to 1.3 cycles per instruction without wait states
    # (loads and taken branches), and the wait states cost at every taken branch, one instruction in eight or so, what
    # the prefetch buffer cannot hide.
    flat_cpi=(Fraction(5, 4), Fraction(11, 8), Fraction(3, 2)),
)

CORTEX_M7 = CoreKind(
    name="Cortex-M7",
    model="M7",
    cpuid=0x411F_C270,  # r1p0
    # DDI0489 table 3-2
    identity=(
        *(0x0000_0030, 0x0000_0200, 0x0010_0000, 0),
        *(0x0010_0030, 0, 0x0100_0000, 0),
        *(0x0110_1110, 0x0211_2000, 0x2023_2231, 0x0111_1131, 0x0131_0132),
    ),
    irq_count=110,  # RM0410 section 10.1
    priority_bits=4,
    vtor_bits=0xFFFF_FF80,
    # BP, branch prediction, and STKALIGN read as one (PM0253 section 4.3.7)
    ccr_reset=0x0004_0200,
    ccr_writable=0x0003_011B,
    actlr_writable=0x1FFF_FC04,
    # TENMS 18750: one millisecond at 18.75 MHz, HCLK / 8 at 150 MHz (RM0410 section 10.1.2); SKEW is assumed
    systick_calibration=1 << 30 | 18750,
    bit_band=False,
    mpu_regions=8,
    fpu=FpuKind(mvfr=(0x1011_0221, 0x1200_0011, 0x0000_0040)),
    # 16 KB of data in 4 ways, 16 KB of instructions in 2 ways, lines of 32 bytes (DDI0489 section 3.3.3)
    ccsidr=(0xF00F_E019, 0xF01F_E009),
    # 16 KB and 128 KB, both enabled, for chips start from them; the other bits are assumed (DDI0489 section 3.3.13)
    tcm=(0x29, 0x41),
    dwt_lock=LOCKED,
    component_ids={  # DDI0489, tables of the ROM table and of the blocks; that ST left TPIU as Arm made it is assumed
        "SCS": (0x0C, 0xB0, 0x0B, 0x00),
        "DWT": (0x02, 0xB0, 0x0B, 0x00),
        "FPB": (0x0E, 0xB0, 0x0B, 0x00),
        "ITM": (0x01, 0xB0, 0x0B, 0x00),
        "TPIU": (0xA9, 0xB9, 0x0B, 0x00),
    },
    # A choice. The core issues up to two instructions in a cycle. Arm gives 5.01 CoreMark per MHz for it and 3.34 for a
    # Cortex-M3, which takes 5/4 cycles per instruction: which comes to 5/6. Code compiled for it issues more pairs,
    # 1/2 being all there can be; 3/4 is between. Wait states cost only what ART accelerator and caches miss, a little
    # more with each of them (RM0410 section 3.3.2 says how many there are).
    flat_cpi=tuple(Fraction(3, 4) + Fraction(wait_states, 64) for wait_states in range(16)),
)

CORTEX_M7_R1P1 = replace(
    CORTEX_M7,
    name="Cortex-M7 r1p1",
    cpuid=0x411F_C271,
    irq_count=150,  # RM0433 section 19.1
    systick_calibration=0x3E8,  # RM0433 section 19.1.1: 1000, one millisecond at 1 MHz
    mpu_regions=16,  # PM0253 section 4.6: of the STM32H7
    tcm=(0x39, 0x41),  # 64 KB and 128 KB
    # Evidence from published programs: Klipper has a "STM32F7 specific DWT unlock", and has counted on CYCCNT without
    # one on the STM32H7 since 2020; OWL's firmware says that it is "required on F7" and leaves it out on the H7. That
    # there is no lock, rather than one that is open, is a choice: only a read of LSR could tell.
    dwt_lock=0,
)

CORES = {kind.name: kind for kind in (CORTEX_M3, CORTEX_M7, CORTEX_M7_R1P1)}
"""Every core by name."""
