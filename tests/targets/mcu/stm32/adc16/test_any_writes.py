"""Whatever a program writes and whenever, the converters keep their own rules and convert afterwards (RM0433 25.5)."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

EN, DIS, START, JSTART, STOP, JSTOP, CAL = 1 << 0, 1 << 1, 1 << 2, 1 << 3, 1 << 4, 1 << 5, 1 << 31
REGULATOR, DEEP = 1 << 28, 1 << 29
LATER = DIS | STOP | JSTOP  # over at once

controls = st.builds(
    lambda low, linear, high: low | linear << 16 | high,
    st.integers(0, 0x3F),
    st.integers(0, 1),
    st.sampled_from([REGULATOR, REGULATOR, REGULATOR | CAL, DEEP, 0, REGULATOR | 0x3F << 22]),
)
words = st.integers(0, 0xFFFF_FFFF)
REGISTERS = [
    *("CFGR", "CFGR2", "SMPR1", "SMPR2", "PCSEL", "LTR1", "HTR1", "SQR1", "SQR2", "SQR4", "JSQR", "OFR1", "OFR3"),
    *("AWD2CR", "HTR2", "DIFSEL", "CALFACT2", "IER"),
]
writes = st.one_of(
    st.tuples(st.just("CR"), controls),
    st.tuples(st.just("CR"), st.sampled_from([REGULATOR | EN, REGULATOR | START, REGULATOR | START | JSTART])),
    st.tuples(st.sampled_from(REGISTERS), words),
    st.tuples(st.just("CFGR"), st.sampled_from([3, 3 | 1 << 13, 1 | 1 << 12 | 1 << 13, 9 << 5 | 1 << 10])),
    st.tuples(st.just("ISR"), st.integers(0, 0x7FF)),
    st.tuples(st.just("CCR"), words),
    st.tuples(st.sampled_from(["DR", "JDR1", "edge", "last", "stop", "go"]), st.just(0)),
)
steps = st.lists(st.tuples(writes, st.integers(0, 20_000)), max_size=40)


def act(rig, what, value):
    match what:
        case "DR" | "JDR1":
            rig.peek(what)
        case "edge":
            rig.trigger("TIM1_TRGO", True)
            rig.trigger("TIM1_TRGO", False)
        case "last":
            rig.requests.line("ADC1").on_last()
        case "stop" | "go":
            rig.kernel_hz = Fraction(60_000_000 if what == "go" else 0)
            rig.adc.after_clock_change()
        case _:
            rig.poke(what, value)


@given(steps=steps)
def test_rules_hold(make_rig, expected, steps):
    rig = make_rig()
    request = rig.requests.line("ADC1")
    for (what, value), cycles in steps:
        act(rig, what, value)
        rig.chip.advance(cycles)
        isr, control = rig.peek("ISR"), rig.peek("CR")
        assert rig.irq.level is bool(isr & rig.peek("IER"))
        assert not request.level or (isr & 0x14 == 0x04 and rig.peek("CFGR") & 3 not in (0, 2))
        assert not control & LATER
        assert not control & (START | JSTART) or control & EN
        assert not control & (EN | CAL) or control & REGULATOR
        assert not (control & EN and control & CAL)
        assert not (control & DEEP and control & REGULATOR)
    act(rig, "go", 0)
    rig.poke("CR", DEEP)
    for register in ("CCR", "SMPR1", "SMPR2", "OFR1", "OFR3"):
        rig.poke(register, 0)
    rig.on()
    rig.clear()
    rig.peek("DR")
    rig.sequence(5)
    rig.start()
    rig.clocks(10)
    assert rig.flags() >= {"EOC", "EOS"}
    assert rig.peek("DR") == expected(0.5)
