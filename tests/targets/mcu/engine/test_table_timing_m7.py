"""Cycles that were chosen for a Cortex-M7."""

from __future__ import annotations

import struct

from targets.mcu.cortexm.kinds import CORTEX_M3, CORTEX_M7
from targets.mcu.engine.api import Reg
from targets.mcu.engine.core_engine import CoreEngine
from targets.mcu.engine.timing import make_timing
from tests.each import each

FLASH, RAM = 0x0800_0000, 0x2000_0000


def cycles_of(halves, *, wait_states=0):
    """Cycles of one instruction; R0 and R1 point into RAM."""
    engine = CoreEngine(make_timing("table", CORTEX_M7), CORTEX_M7)
    engine.map_memory(FLASH, bytearray(struct.pack(f"<{len(halves)}H", *halves).ljust(0x400, b"\0")), writable=False)
    engine.map_memory(RAM, bytearray(0x400), writable=True)
    for register, value in ((Reg.SP, RAM + 0x400), (Reg.R0, RAM + 0x200), (Reg.R1, RAM + 0x100)):
        engine.set(register, value)
    engine.set(Reg.XPSR, 1 << 24)
    engine.set(Reg.PC, FLASH)
    engine.set_wait_states(wait_states)
    engine.run(1 << 40, 1)
    assert engine.instructions == 1
    return engine.cycle


@each(
    ("halves", "cycles"),
    [
        ((0xBF00,), 1),
        ((0x6808,), 1),  # ldr r0, [r1]
        ((0x4800,), 1),  # ldr r0, [pc]
        ((0xB40F,), 2),  # push {r0-r3}
        ((0xB500,), 1),  # push {lr}
        ((0xC90E,), 2),  # ldmia r1!, {r1-r3}
        ((0xE891, 0x003C), 2),
        ((0xE9D1, 0x2300), 1),  # ldrd
        ((0xFBA2, 0x2304), 1),  # umull
        ((0xFB92, 0xF2F3), 7),  # sdiv
        ((0xB672,), 2),  # cpsid i
        ((0xF380, 0x8811), 2),  # msr basepri, r0
        ((0xEE30, 0x0A20), 1),  # vadd.f32
        ((0xEE30, 0x0B01), 1),  # vadd.f64
        ((0xEE20, 0x0A20), 1),  # vmul.f32
        ((0xEE20, 0x0B01), 3),  # vmul.f64
        ((0xEEA0, 0x0B01), 3),  # vfma.f64
        ((0xEE80, 0x0A20), 14),  # vdiv.f32
        ((0xEE80, 0x0B01), 28),  # vdiv.f64
        ((0xEEB1, 0x0BC0), 28),  # vsqrt.f64
        ((0xEEB1, 0x0B40), 1),  # vneg.f64
        ((0xEE00, 0x0B10), 1),  # vmov.32 d0[0], r0
        ((0xED90, 0x0A40), 1),  # vldr s0, [r0, #256]
        ((0xECB0, 0x0A08), 4),  # vldmia r0!, {s0-s7}
        ((0xED2D, 0x8B10), 8),  # vpush {d8-d15}
        ((0xEC41, 0x0A10), 1),  # vmov s0, s1, r0, r1
    ],
)
def test_instructions(halves, cycles):
    assert cycles_of(halves) == cycles


@each("halves", [(0xE000,), (0xF000, 0xB801), (0xF000, 0xF801)])  # b, b.w, bl
def test_a_branch_taken_takes_one_more(halves):
    assert cycles_of(halves) == 2


def test_flat_is_faster_and_wait_states_hardly_show():
    m7, m3 = (CoreEngine(make_timing("flat", kind), kind) for kind in (CORTEX_M7, CORTEX_M3))
    assert (m7.timing.cycle(10_000), m3.timing.cycle(10_000)) == (7500, 12_500)
    m7.set_wait_states(7)
    assert 8000 < m7.timing.cycle(10_000) < 9000


@each(("halves", "cycles"), [((0xE000,), 2), ((0x4800,), 1)])  # b, ldr r0, [pc]
def test_the_table_does_not_know_wait_states(halves, cycles):
    assert cycles_of(halves, wait_states=7) == cycles
