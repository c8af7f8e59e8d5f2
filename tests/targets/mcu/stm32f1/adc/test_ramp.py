"""A ramp at a pin, converted after each trigger and in each mode: every code is that of the moment of sampling.

RM0008 sections 11.7 and 11.12: sampling takes 1.5 to 239.5 clocks, the conversion 12.5.
"""

from __future__ import annotations

from itertools import pairwise

import pytest

from tests.targets.mcu.stm32f1.adc.test_triggers import ROWS

FULL_NS = 1_000_000  # from 0 V to 3.3 V: a code for each 3.4 clocks
NS_PER_CYCLE = 1e9 / 56_000_000
CYCLES, CONVERSION = 4, 12.5
SAMPLED_BEFORE = CYCLES * CONVERSION


def begin_ramp(rig):
    rig.pins["PA1"].drive_ramp(0.0, 3.3, in_ns=FULL_NS)
    return rig.chip.time.now


def code_at(cycle, begun):
    """The code of the ramp at a cycle."""
    return min(int((cycle - begun) * NS_PER_CYCLE / FULL_NS * 4096 + 0.5), 4095)


def wait_for(rig, flag, unit=1):
    """Go on clock by clock until a flag is set; return the cycle."""
    for _ in range(5000):
        if flag in rig.flags(unit):
            return rig.chip.time.now
        rig.chip.advance(1)
    raise AssertionError(f"no {flag}")


def test_after_each_trigger(make_rig):
    for unit, number, name, moved, injected in ROWS:
        rig = make_rig()
        if moved:
            rig.moved.add(f"ADC{unit}_{'ETRGINJ' if injected else 'ETRGREG'}")
        rig.on(cr2=1 << 15 | number << 12 if injected else 1 << 20 | number << 17, unit=unit)
        (rig.injected if injected else rig.sequence)(1, unit=unit)
        begun = begin_ramp(rig)
        rig.chip.advance(12_345)
        rig.trigger(name)
        started = rig.chip.time.now
        ended = wait_for(rig, "JEOC" if injected else "EOC", unit)
        assert ended - started == CYCLES * 14, name
        assert rig.peek("JDR1" if injected else "DR", unit) == code_at(ended - SAMPLED_BEFORE, begun), name


SCAN, DISCEN, CONT, DMA = 1 << 8, 1 << 11, 1 << 1, 1 << 8
MODES = {
    "single": (0, 0, 1),
    "continuous": (0, CONT, 1),
    "scan": (SCAN, 0, 5),
    "scan continuous": (SCAN, CONT, 3),
    "discontinuous": (SCAN | DISCEN | 1 << 13, 0, 6),
}
SAMPLING = (1.5, 7.5, 13.5, 28.5, 41.5, 55.5, 71.5, 239.5)


@pytest.mark.parametrize("unit", [1, pytest.param(3, marks=pytest.mark.exhaustive("as ADC1; the gate has that"))])
def test_in_each_mode_with_each_sampling_time(make_rig, unit):
    for mode, (cr1, cr2, ranks) in MODES.items():
        for number, clocks in enumerate(SAMPLING):
            rig = make_rig()
            rig.on(cr1, cr2 | DMA, unit=unit)
            rig.poke("SMPR2", number << 3, unit)
            rig.sequence(*[1] * ranks, unit=unit)
            begun = begin_ramp(rig)
            rig.chip.advance(321)
            drained, found = rig.chip.time.now, rig.drain(unit)
            for _ in range(3):
                rig.start(unit)
                rig.clocks(6 * (clocks + CONVERSION) + 2)
            ends = [drained + CYCLES * clock for clock, _ in found]
            where = f"{mode}, {clocks} clocks"
            assert len(found) >= {"single": 3, "scan": 15, "discontinuous": 6}.get(mode, 17), where
            assert [value for _, value in found] == [code_at(end - SAMPLED_BEFORE, begun) for end in ends], where
            gaps = {later - earlier for earlier, later in pairwise(ends[:ranks])}
            assert gaps <= {CYCLES * (clocks + CONVERSION)} or mode == "discontinuous", where


def test_injected_groups_beside_a_regular_one(rig):
    """JAUTO: four more of the same ramp after each; each code is that of its moment."""
    rig.on(SCAN | 1 << 10, 0)
    rig.sequence(1)
    rig.injected(1, 1, 1, 1)
    begun = begin_ramp(rig)
    rig.start()
    ended = wait_for(rig, "JEOC")
    codes = [rig.peek("DR"), *(rig.peek(f"JDR{rank}") for rank in range(1, 5))]
    assert codes == [code_at(ended - SAMPLED_BEFORE - CYCLES * 14 * left, begun) for left in (4, 3, 2, 1, 0)]
