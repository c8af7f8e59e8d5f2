"""The timers of the STM32F7 against the one that does every tick: the same behaviour, and inputs of both edges."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from targets.mcu.services import Watch
from targets.mcu.stm32.tim.kinds import F7_KINDS
from tests.each import each
from tests.share import examples

SMALL = st.integers(0, 12)
NAMES = st.sampled_from(["TIM1", "TIM3"])


def channels(*, inputs):
    output = st.builds(lambda mode, preload: mode << 4 | preload, st.integers(0, 7), st.sampled_from([0, 8]))
    capture = st.builds(lambda select, every: every << 2 | select, st.integers(1, 3), st.integers(0, 2))
    byte = st.one_of(output, capture) if inputs else output
    return st.builds(lambda low, high: low | high << 8, byte, byte)


def combined():
    """Two channels, one or both of which make OCxREFC of the two: combined or asymmetric PWM."""
    plain = st.integers(0, 7)
    extended = st.integers(12, 15)
    return st.builds(
        lambda first, second, preload: (
            (first & 7) << 4 | (first >> 3) << 16 | (second & 7) << 12 | (second >> 3) << 24 | preload * 0x0808
        ),
        extended,
        st.one_of(plain, extended),
        st.integers(0, 1),
    )


def steps(*, inputs, combinations=False):
    write = st.one_of(
        st.tuples(
            st.just("CR1"),
            st.builds(
                lambda run, bits, centre: run | bits | centre << 5,
                st.sampled_from([1, 1, 0]),
                st.sampled_from([0, 0, 0x80, 0x10, 2, 4, 8]),
                st.sampled_from([0, 0, 1, 2, 3]),
            ),
        ),
        *[st.tuples(st.just(name), SMALL) for name in ("ARR", "CCR1", "CCR2", "CCR3", "CCR4")],
        st.tuples(st.just("PSC"), st.integers(0, 3)),
        st.tuples(st.just("RCR"), st.integers(0, 3)),
        st.tuples(st.just("CNT"), st.one_of(SMALL, st.integers(0xFFF8, 0xFFFF))),
        st.tuples(st.just("EGR"), st.sampled_from([1, 2, 0x1E, 0x5F])),
        st.tuples(st.just("SR"), st.sampled_from([0, 0xFFFF, 0xFFFE])),
        st.tuples(st.just("DIER"), st.integers(0, 0x7FFF)),
        st.tuples(
            st.sampled_from(["CCMR1", "CCMR1", "CCMR2"]),
            st.one_of(combined(), channels(inputs=inputs)) if combinations else channels(inputs=inputs),
        ),
        st.tuples(st.just("CCER"), st.one_of(st.integers(0, 0xBFFF), st.just(0xBBBB))),
        st.tuples(st.just("CR2"), st.sampled_from([0, 0x20, 0x30, 0x80, 8])),
        st.tuples(st.just("BDTR"), st.sampled_from([0x8000, 0x8003, 0xCC00, 0])),
    )
    edge = st.tuples(st.sampled_from(["CH1", "CH1", "CH2", "CH3", "CH4", "ETR", "ITR", "BKIN"]), st.booleans())
    trigger = st.tuples(
        st.just("SMCR"),
        st.builds(
            lambda mode, source, bits: mode | source << 4 | bits,
            st.integers(0, 7),
            st.integers(0, 7),
            st.sampled_from([0, 0, 0x4000, 0x8000]),
        ),
    )
    action = st.one_of(write, edge, trigger) if inputs else write
    return st.lists(st.tuples(st.integers(0, 30), action), min_size=10, max_size=40)


def play(bench, actions, first=()):
    for name, value in first:
        bench.write(name, value)
    for name, value in (("ARR", 9), ("CCR1", 4), ("CR1", 1)):
        bench.write(name, value)
    for cycles, (what, value) in actions:
        bench.advance(cycles)
        if what in ("CH1", "CH2", "CH3", "CH4", "ETR", "ITR", "BKIN"):
            bench.drive(what, value)
        else:
            bench.write(what, value)
        bench.compare()
    bench.advance(80)
    bench.compare()
    bench.compare_log()


@settings(max_examples=examples(100))
@given(actions=steps(inputs=False), name=NAMES, watch=st.sampled_from(list(Watch)))
def test_outputs(make_bench, actions, name, watch):
    bench = make_bench(name, kinds=F7_KINDS)
    for output in bench.OUTPUTS:
        bench.output(output).set_watch(watch)
    play(bench, actions)
    bench.compare_outputs()
    if watch is not Watch.NOBODY:
        bench.compare_edges()


@settings(max_examples=examples(150))
@given(actions=steps(inputs=True), name=NAMES)
def test_inputs(make_bench, actions, name):
    bench = make_bench(name, kinds=F7_KINDS)
    play(bench, actions)
    bench.compare_edges()


@each("name", ["TIM1", "TIM3"])
def test_an_input_of_both_edges_captures_each(make_bench, name):
    bench = make_bench(name, kinds=F7_KINDS)
    for register, value in (("CCMR1", 0x01), ("CCER", 0x0B), ("ARR", 100), ("CR1", 1), ("DIER", 0x200)):
        bench.write(register, value)
    for level in (True, False, True):
        bench.advance(10)
        bench.drive("CH1", level)
        bench.read("CCR1")
    bench.compare_log()
    assert len(bench.chip.dma(f"{name}_CH1").pulses) == 3


@settings(max_examples=examples(200))
@given(
    actions=steps(inputs=False, combinations=True),
    first=combined(),
    centre=st.sampled_from([0, 0x20, 0x40, 0x60]),
    name=NAMES,
    watch=st.sampled_from(list(Watch)),
)
def test_combined_and_asymmetric_pwm(make_bench, actions, first, centre, name, watch):
    bench = make_bench(name, kinds=F7_KINDS)
    for output in bench.OUTPUTS:
        bench.output(output).set_watch(watch)
    setup = [("CR1", centre), ("CCMR1", first), ("CCR2", 7), ("CCER", 0x1111), ("BDTR", 0x8000)]
    play(bench, actions, setup)
    bench.advance(300)
    bench.compare_outputs()
    if watch is not Watch.NOBODY:
        bench.compare_edges()
