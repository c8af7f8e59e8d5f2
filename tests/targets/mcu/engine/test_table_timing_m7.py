"""Cycles that were chosen for a Cortex-M7."""

from __future__ import annotations

import pytest

from targets.mcu.cortexm.kinds import CORTEX_M3, CORTEX_M7
from targets.mcu.engine.opcode_cycles_m7 import DIVIDE, cost_of
from targets.mcu.engine.timing import make_timing


@pytest.mark.parametrize(
    ("halves", "cycles"),
    [
        ((0xBF00, 0), 1),
        ((0x6808, 0), 1),  # ldr r0, [r1]
        ((0x4800, 0), 1),  # ldr r0, [pc]
        ((0xB40F, 0), 2),  # push {r0-r3}
        ((0xB500, 0), 1),  # push {lr}
        ((0xC90E, 0), 2),  # ldmia r1!, {r1-r3}
        ((0xE891, 0x003C), 2),
        ((0xE9D1, 0x2300), 1),  # ldrd
        ((0xFBA2, 0x2304), 1),  # umull
        ((0xFB92, 0xF2F3), DIVIDE),
        ((0xB672, 0), 2),  # cpsid i
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
    assert cost_of(*halves).cycles == cycles


def test_flat_is_faster_and_wait_states_hardly_show():
    flat, m3 = make_timing("flat", CORTEX_M7), make_timing("flat", CORTEX_M3)
    assert (flat.cycle(10_000), m3.cycle(10_000)) == (7500, 12_500)
    flat.set_wait_states(7, 0)
    assert 8000 < flat.cycle(10_000) < 9000


def test_the_table_does_not_know_wait_states():
    table = make_timing("table", CORTEX_M7)
    table.set_wait_states(7, 0)
    assert table._wait_states == 0
