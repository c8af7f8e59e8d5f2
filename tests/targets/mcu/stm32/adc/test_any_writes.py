"""Whatever a program writes and whenever, the converters keep their own rules and convert afterwards."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

ON, SWSTART, JSWSTART, DMA = 1, 1 << 30, 1 << 22, 1 << 8

cr2 = st.builds(
    lambda low, dma, start: ON | low << 1 | dma << 8 | start,
    st.integers(0, 1),
    st.integers(0, 15),
    st.sampled_from([0, SWSTART, JSWSTART, SWSTART | JSWSTART, 1 << 28 | 11 << 24, 3 << 20 | 2 << 16]),
)
writes = st.one_of(
    st.tuples(st.just("CR2"), cr2),
    st.tuples(st.just("CR2"), st.sampled_from([0, ON])),
    st.tuples(st.just("CR1"), st.integers(0, 0x07C0_FFFF)),
    st.tuples(st.sampled_from(["SQR1", "SQR3", "JSQR", "SMPR2", "JOFR1", "HTR", "LTR"]), st.integers(0, 0xFFFF_FFFF)),
    st.tuples(st.just("SR"), st.integers(0, 0x3F)),
    st.tuples(st.just("CCR"), st.integers(0, 0xFFFF_FFFF)),
    st.tuples(st.sampled_from(["DR", "edge", "last", "stop", "go"]), st.just(0)),
)
steps = st.lists(st.tuples(writes, st.integers(0, 4000)), max_size=40)


def act(rig, what, value):
    match what:
        case "DR":
            rig.peek("DR")
        case "edge":
            rig.trigger("TIM2_TRGO", True)
            rig.trigger("TIM2_TRGO", False)
        case "last":
            rig.requests.line("ADC1").on_last()
        case "stop" | "go":
            rig.chip.change_clock(APB2=0 if what == "stop" else 2)
        case _:
            rig.poke(what, value)


@given(steps=steps)
def test_rules_hold(make_rig, expected, steps):
    rig = make_rig()
    request = rig.requests.line("ADC1")
    for (what, value), cycles in steps:
        act(rig, what, value)
        rig.chip.advance(cycles)
        flags, enables = rig.flags(), rig.peek("CR1")
        wanted = [
            flag in flags and enables >> bit & 1 for flag, bit in (("EOC", 5), ("AWD", 6), ("JEOC", 7), ("OVR", 26))
        ]
        assert rig.irq.level is any(wanted)
        assert not (request.level and "OVR" in flags)
        assert not request.level or rig.peek("CR2") & DMA
        assert not rig.peek("CR2") & (SWSTART | JSWSTART)
    rig.chip.change_clock(APB2=2)
    rig.poke("CCR", 1 << 16)
    rig.poke("SMPR2", 0)
    rig.poke("CR2", 0)
    rig.clear()
    rig.on()
    rig.sequence(5)
    rig.start()
    rig.clocks(15)
    assert rig.flags() == {"STRT", "EOC"}
    assert rig.peek("DR") == expected(5)
